// The web page as browsers ask it, in front of a coordinator.
#include "service/web/web_site.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <nlohmann/json.hpp>

#include "service/coordinator_impl.h"
#include "service/farm/farm.h"
#include "service/farm/farm_views.h"
#include "service/job/job_table.h"
#include "unit/server/coordinator_fixture.h"
#include "unit/server/requests.h"

namespace tessera::server {
namespace {

HttpRequest request_for(const std::string& method, const std::string& path) {
  HttpRequest request;
  request.method = method;
  request.path = path;
  request.host = "localhost";
  return request;
}

class WebSiteTest : public CoordinatorTest {
 protected:
  void SetUp() override {
    CoordinatorOptions options;
    options.web = "127.0.0.1:0";
    start(options);
  }

  HttpAnswer get(const std::string& path, std::map<std::string, std::string> query = {}) {
    HttpRequest request = request_for("GET", path);
    request.query = std::move(query);
    return site().answer(request);
  }
  HttpAnswer post(const std::string& path, const std::string& body) {
    HttpRequest request = request_for("POST", path);
    request.content_type = "application/json";
    request.marker = "1";
    request.body = body;
    return site().answer(request);
  }
  unsigned act(const std::string& action, const std::string& id) {
    return post("/api/" + action, nlohmann::json{{"id", id}}.dump()).status;
  }
  /// The news that a page hears within a few rounds, until it hears `awaited`.
  std::string hear(EventStream& stream, const std::string& awaited) {
    std::string heard;
    std::mutex mutex;
    std::condition_variable woken;
    bool awake = false;
    while (heard.find(awaited) == std::string::npos) {
      char buffer[4096];
      const std::size_t count = stream.take(
          buffer, sizeof(buffer), [] {},
          [&] {
            const std::lock_guard lock(mutex);
            awake = true;
            woken.notify_all();
          });
      heard.append(buffer, count);
      if (count > 0) continue;
      if (stream.closed()) break;
      std::unique_lock lock(mutex);
      woken.wait(lock, [&] { return awake; });
      awake = false;
    }
    stream.abandon();
    return heard;
  }
  WebSite& site() { return *coordinator_->impl().site; }
};

TEST_F(WebSiteTest, ServesThePageFromTheProgram) {
  std::size_t bytes = 0;
  for (const char* path : {"/", "/page.css", "/page.js", "/frame.js", "/table.js", "/strip.js", "/color.js",
                           "/spectrum.js", "/meter.js", "/false_color.js", "/icon.svg"}) {
    const HttpAnswer answer = get(path);
    EXPECT_EQ(answer.status, 200u) << path;
    bytes += answer.body.size();
  }
  EXPECT_LT(bytes, 300'000u);
  EXPECT_EQ(get("/index.html").status, 404u);
  EXPECT_EQ(get("/../server/main.cpp").status, 404u);
}

TEST_F(WebSiteTest, HandlesJobsAsTheCommandLineDoes) {
  const std::string id = submit(job_spec());
  EXPECT_EQ(act("pause", id), 200u);
  EXPECT_TRUE(job(id).paused());
  EXPECT_EQ(act("resume", id), 200u);
  EXPECT_FALSE(job(id).paused());
  EXPECT_EQ(post("/api/priority", nlohmann::json{{"id", id}, {"priority", -3}}.dump()).status, 200u);
  EXPECT_EQ(job(id).priority(), -3);
  EXPECT_EQ(act("cancel", id), 200u);
  EXPECT_EQ(job(id).state(), v1::CANCELLED);
  EXPECT_EQ(act("retry", id), 409u) << "as FAILED_PRECONDITION";
  EXPECT_EQ(act("cancel", "nothing"), 404u);
}

TEST_F(WebSiteTest, RefusesWhatIsNoRequestOfThePage) {
  const std::string id = submit(job_spec());
  EXPECT_EQ(post("/api/upload", "{}").status, 404u);
  EXPECT_EQ(post("/api/cancel", "not JSON").status, 400u);
  EXPECT_EQ(post("/api/cancel", "[]").status, 400u);
  for (const char* priority : {"\"1\"", "1e99", "1.5", "null"})
    EXPECT_EQ(post("/api/priority", "{\"id\":\"" + id + "\",\"priority\":" + priority + "}").status, 400u)
        << priority;
  HttpRequest request = request_for("POST", "/api/cancel");
  request.body = "{\"id\":\"" + id + "\"}";
  EXPECT_EQ(site().answer(request).status, 403u) << "as a form sends it";
  request.host = "evil.example";
  EXPECT_EQ(site().answer(request).status, 403u);
  EXPECT_EQ(job(id).state(), v1::QUEUED);
}

TEST_F(WebSiteTest, GivesPixelsOfResults) {
  const std::string id = submit(job_spec());
  const std::string worker = register_worker();
  const v1::LeaseResponse leases = lease(worker, 4);
  const auto shape = coordinator_->farm().views().shape_of(id);
  ASSERT_TRUE(shape.ok());
  std::map<std::string, std::string> part{{"job", id}, {"layer", "samples"}, {"level", "0"}, {"x0", "0"},
                                          {"y0", "0"}, {"x1", "1"},          {"y1", "1"}};
  const auto value = [&] {
    const std::string body = get("/api/pixels", part).body;
    float sample = -1;
    if (body.size() == sizeof(sample)) std::memcpy(&sample, body.data(), sizeof(sample));
    return sample;
  };
  EXPECT_TRUE(std::isnan(value())) << "nothing yet";
  const HttpAnswer events = get("/api/events", {{"job", id}, {"layer", "samples"}, {"workers", ""}});
  ASSERT_NE(events.events, nullptr);
  for (const v1::Lease& lease : leases.leases())
    ASSERT_TRUE(complete(worker, lease, payload_for(lease.unit())).ok());
  const std::string heard = hear(*events.events, "\"state\":\"DONE\"");
  EXPECT_THAT(heard, testing::HasSubstr("event: workers"));
  EXPECT_THAT(heard, testing::HasSubstr("event: picture"));
  // Who comes after the job's end hears of the picture when all results are in it.
  const HttpAnswer later = get("/api/events", {{"job", id}, {"layer", "samples"}});
  ASSERT_NE(later.events, nullptr);
  static_cast<void>(hear(*later.events, "event: picture\ndata: {\"all\":true"));
  EXPECT_EQ(value(), static_cast<float>((*shape)->spec.samples().spp()));
  for (const auto& [name, wrong] : std::map<std::string, std::string>{{"level", "17"},
                                                                      {"x1", "0"},
                                                                      {"x1", "70000"},
                                                                      {"y1", "-1"},
                                                                      {"x0", "a"},
                                                                      {"layer", "nothing"},
                                                                      {"job", "nothing"}}) {
    auto bad = part;
    bad[name] = wrong;
    EXPECT_THAT(get("/api/pixels", bad).status, testing::AnyOf(400u, 404u)) << name << " " << wrong;
  }
}

TEST_F(WebSiteTest, GivesTheSpectrumOfAPixel) {
  v1::JobSpec spec = job_spec();
  spec.mutable_content()->mutable_algorithms()->set_color(v1::COLOR_SPECTRAL);
  spec.mutable_view()->set_film("spectral:4:400-600");
  const std::string id = submit(spec);
  const std::string worker = register_worker();
  const v1::LeaseResponse leases = lease(worker, 4);
  const auto shape = coordinator_->farm().views().shape_of(id);
  ASSERT_TRUE(shape.ok());
  std::map<std::string, std::string> place{{"job", id}, {"layer", "color"}, {"x", "3"}, {"y", "2"}};
  const auto told = [&] { return nlohmann::json::parse(get("/api/spectrum", place).body); };
  EXPECT_EQ(told()["samples"], 0);
  EXPECT_TRUE(told()["values"].empty());
  const HttpAnswer events = get("/api/events", {{"job", id}, {"layer", "color"}});
  ASSERT_NE(events.events, nullptr);
  for (const v1::Lease& lease : leases.leases()) {
    absl::StatusOr<wire::TileResult> result = wire::decode_tile_result(payload_for(lease.unit()));
    ASSERT_TRUE(result.ok());
    result->channels = (*shape)->channels;
    const std::size_t pixels = result->pixel_count();
    result->values.assign(pixels * result->channels.size(), 0);
    for (std::size_t c = 0; c < result->channels.size(); ++c) {
      if (!result->channels[c].name.starts_with("S0.")) continue;
      // A value of its own in each band and pixel, the same in all samples.
      for (std::size_t i = 0; i < pixels; ++i)
        result->values[c * pixels + i] = static_cast<float>(result->counts[i] * (c + 0.5 * (i % 32)));
    }
    ASSERT_TRUE(complete(worker, lease, wire::encode_tile_result(*result)).ok());
  }
  static_cast<void>(hear(*events.events, "\"state\":\"DONE\""));
  const HttpAnswer later = get("/api/events", {{"job", id}, {"layer", "color"}});
  ASSERT_NE(later.events, nullptr);
  static_cast<void>(hear(*later.events, "event: picture\ndata: {\"all\":true"));
  const nlohmann::json spectrum = told();
  EXPECT_EQ(spectrum["samples"], (*shape)->spec.samples().spp());
  EXPECT_EQ(spectrum["nm"], nlohmann::json({425.0, 475.0, 525.0, 575.0}));
  ASSERT_EQ(spectrum["values"].size(), 4u);
  const double first = spectrum["values"][0];
  for (std::size_t band = 1; band < 4; ++band)
    EXPECT_FLOAT_EQ(spectrum["values"][band], first + static_cast<double>(band));
  place["x"] = "4";
  EXPECT_FLOAT_EQ(told()["values"][0], first + 0.5);
  for (const auto& [name, wrong] : std::map<std::string, std::string>{
           {"x", "70000"}, {"y", "-1"}, {"x", ""}, {"layer", "nothing"}, {"job", "nothing"}}) {
    auto bad = place;
    bad[name] = wrong;
    EXPECT_THAT(get("/api/spectrum", bad).status, testing::AnyOf(400u, 404u)) << name << " " << wrong;
  }
  place["job"] = submit(job_spec());
  EXPECT_EQ(get("/api/spectrum", place).status, 400u) << "its film has no bands";
}

TEST_F(WebSiteTest, MeasuresTheLightOfAPixel) {
  v1::Scene scene;
  scene.mutable_camera()->mutable_perspective();
  scene.mutable_units()->set_cd_per_m2(100);
  const std::string bytes = scene.SerializeAsString();
  ASSERT_TRUE(upload(bytes).ok());
  v1::JobSpec spec = square_spec(bytes, 32, 1);
  spec.mutable_view()->add_aovs(v1::AOV_VARIANCE);
  spec.mutable_view()->set_reconstruction(v1::RECONSTRUCTION_SAMPLE);
  const std::string id = submit(spec);
  const std::string worker = register_worker();
  const v1::LeaseResponse leases = lease(worker, 4);
  const auto shape = coordinator_->farm().views().shape_of(id);
  ASSERT_TRUE(shape.ok());
  std::map<std::string, std::string> place{{"job", id}, {"x", "16"}, {"y", "20"}};
  const auto told = [&] { return nlohmann::json::parse(get("/api/meter", place).body); };
  EXPECT_EQ(told()["pixel"]["samples"], 0);
  // Grey pixels of x, in all samples; squared deviations are n (n - 1), so that errors are 1 in each channel.
  for (const v1::Lease& lease : leases.leases()) {
    absl::StatusOr<wire::TileResult> result = wire::decode_tile_result(payload_for(lease.unit()));
    ASSERT_TRUE(result.ok());
    result->channels = (*shape)->channels;
    const std::size_t pixels = result->pixel_count(), width = result->x1 - result->x0;
    result->values.assign(pixels * result->channels.size(), 0);
    for (std::size_t c = 0; c < result->channels.size(); ++c) {
      const bool deviations = result->channels[c].kind == wire::ChannelKind::kSquaredDeviation;
      for (std::size_t i = 0; i < pixels; ++i) {
        const auto count = static_cast<float>(result->counts[i]),
                   x = static_cast<float>(result->x0 + i % width);
        result->values[c * pixels + i] = deviations ? count * (count - 1) : count * x;
      }
    }
    ASSERT_TRUE(complete(worker, lease, wire::encode_tile_result(*result)).ok());
  }
  const nlohmann::json light = told();
  const auto spp = (*shape)->spec.samples().spp();
  EXPECT_EQ(light["pixel"]["samples"], spp);
  EXPECT_FLOAT_EQ(light["pixel"]["luminance"], 16);
  EXPECT_NEAR(light["pixel"]["error"].get<double>(), 1, 1e-5) << "the weights of channels add up to 1";
  EXPECT_EQ(light["block"]["pixels"], 64);
  EXPECT_FLOAT_EQ(light["block"]["luminance"], 15.5) << "pixels 12 to 19, across the edge of tiles";
  EXPECT_NEAR(light["block"]["error"].get<double>(), 1 / 8.0, 1e-6) << "of 64 pixels";
  EXPECT_EQ(light["variance"], true);
  EXPECT_EQ(light["shares"], false);
  EXPECT_EQ(light["units"]["cd_per_m2"], 100);
  EXPECT_EQ(nlohmann::json::parse(get("/api/units", {{"job", id}}).body), light["units"]);
  place["x"] = "0";
  EXPECT_EQ(told()["block"]["pixels"], 4 * 8) << "at the edge of the picture";
  for (const auto& [name, wrong] :
       std::map<std::string, std::string>{{"x", "70000"}, {"y", "-1"}, {"x", ""}, {"job", "nothing"}}) {
    auto bad = place;
    bad[name] = wrong;
    EXPECT_THAT(get("/api/meter", bad).status, testing::AnyOf(400u, 404u)) << name << " " << wrong;
  }
  EXPECT_EQ(get("/api/units", {{"job", "nothing"}}).status, 404u);
}

TEST_F(WebSiteTest, ReadsFinerLevelsOfLargeFramesFromResults) {
  v1::JobSpec spec = job_spec();
  spec.mutable_cut()->set_tile_size(256);
  spec.mutable_view()->set_width(16384);
  spec.mutable_view()->set_height(16384);
  spec.mutable_cut()->mutable_crop()->set_x1(16384);
  spec.mutable_cut()->mutable_crop()->set_y1(16384);
  const std::string id = submit(spec);
  const std::string worker = register_worker();
  const v1::LeaseResponse leases = lease(worker, 1);
  ASSERT_EQ(leases.leases_size(), 1);
  const v1::PixelRect done = leases.leases(0).unit().tile().pixels();
  ASSERT_TRUE(complete(worker, leases.leases(0), payload_for(leases.leases(0).unit())).ok());
  ShownPicture picture{coordinator_->farm().views(),
                       id,
                       *coordinator_->farm().views().shape_of(id),
                       {.name = "samples", .kind = PictureLayer::Kind::kSamples, .channels = {}}};
  while (picture.follow(std::chrono::steady_clock::time_point::max())) continue;
  EXPECT_EQ(Picture::level_for(picture.area()), 3u) << "2048 x 2048 pixels of it are kept";
  for (const std::uint32_t level : {0u, 1u, 3u, 6u}) {
    const std::uint32_t x = done.x0() >> level, y = done.y0() >> level;
    const auto pixel = [&](std::uint32_t column) {
      const absl::StatusOr<std::string> bytes = picture.part(level, {column, y, column + 1, y + 1});
      EXPECT_TRUE(bytes.ok()) << bytes.status();
      float value = 0;
      if (bytes.ok() && bytes->size() == sizeof(value)) std::memcpy(&value, bytes->data(), sizeof(value));
      return value;
    };
    EXPECT_EQ(pixel(x), 4) << level;
    EXPECT_EQ(pixel(x + (255u >> level)), 4) << level;
    EXPECT_TRUE(std::isnan(pixel(x + (256u >> level)))) << level << ": the next tile is not there";
  }
}

TEST_F(WebSiteTest, BoundsTheMemoryOfPicturesThatAreLookedAt) {
  const std::string id = submit(job_spec());
  const PixelArea area{0, 0, 32, 32};
  const auto shape = coordinator_->farm().views().shape_of(id);
  ASSERT_TRUE(shape.ok());
  const std::vector<PictureLayer> layers = layers_of((*shape)->channels, /*has_pilot=*/false);
  const auto bytes = [&](const char* name) {
    return Picture::bytes_for(area, *std::ranges::find(layers, name, &PictureLayer::name));
  };
  EXPECT_EQ(bytes("color"), 4 * sizeof(float) * 32 * 32) << "weights and three sums";
  Pictures pictures{coordinator_->farm().views(), bytes("color") + bytes("samples")};
  auto color = pictures.open(id, "color");
  auto samples = pictures.open(id, "samples");
  ASSERT_TRUE(color.ok() && samples.ok());
  EXPECT_EQ(*pictures.open(id, "color"), *color) << "who comes later looks at the same";
  EXPECT_TRUE(absl::IsResourceExhausted(pictures.open(id, "cost").status())) << "all are looked at";
  samples = absl::CancelledError();
  EXPECT_TRUE(pictures.open(id, "cost").ok()) << "nobody looks at the other any more";
}

TEST_F(WebSiteTest, BoundsOpenPages) {
  std::vector<HttpAnswer> open;
  for (std::size_t i = 0; i < Feed::kMostStreams; ++i) open.push_back(get("/api/events"));
  EXPECT_NE(open.back().events, nullptr);
  EXPECT_EQ(get("/api/events").status, 429u);
  open.front().events->abandon();
  EXPECT_NE(get("/api/events").events, nullptr);
}

TEST(WebSiteWithCertificates, ServesThoseWhoLoggedInWithTheirRights) {
  auto expelled = *Expelled::open({});
  auto members = *Members::open({});
  CoordinatorOptions options;
  options.takes_messages = false;
  const auto coordinator = *Coordinator::start(options);
  Farm& farm = coordinator->farm();
  WebSite site{farm,
               Rights{farm.views(), /*share_jobs=*/false},
               *expelled,
               *members,
               {.encrypted = true, .version = "0"}};
  const auto ask = [&](const std::string& path, const std::string& session) {
    HttpRequest request = request_for("GET", path);
    request.cookie = "other=1; tessera-session=" + session;
    return site.answer(request).status;
  };
  const auto log_in = [&](const Visitor& who) -> std::string {
    const auto token = site.make_token(who, std::chrono::minutes{1});
    HttpRequest request = request_for("POST", "/api/login");
    request.content_type = "application/json";
    request.marker = "1";
    request.body = nlohmann::json{{"token", *token}}.dump();
    const HttpAnswer answer = site.answer(request);
    EXPECT_EQ(answer.status, 200u);
    for (const auto& [name, value] : answer.headers) {
      if (name != "Set-Cookie") continue;
      EXPECT_THAT(value, testing::AllOf(testing::HasSubstr("HttpOnly"), testing::HasSubstr("Secure"),
                                        testing::HasSubstr("SameSite=Strict")));
      return value.substr(value.find('=') + 1, Logins::kSecretDigits);
    }
    return "";
  };
  EXPECT_EQ(ask("/", ""), 200u) << "the page, which asks for a login";
  for (const char* path :
       {"/api/me", "/api/events", "/api/job", "/api/pixels", "/api/spectrum", "/api/meter", "/api/units"})
    EXPECT_EQ(ask(path, ""), 401u) << path;
  const std::string ada = log_in({.caller = {.role = Role::kClient, .user = "ada"}, .certificate = ""});
  EXPECT_EQ(ask("/api/me", ada), 200u);
  EXPECT_EQ(ask("/api/me", std::string(Logins::kSecretDigits, '0')), 401u);
  const std::string worker = log_in({.caller = {.role = Role::kWorker, .user = "node"}, .certificate = ""});
  EXPECT_EQ(ask("/api/me", worker), 403u) << "workers are not clients";
  std::vector<std::shared_ptr<EventStream>> pages;
  const auto open_page = [&](const std::string& session) {
    HttpRequest request = request_for("GET", "/api/events");
    request.cookie = "tessera-session=" + session;
    const HttpAnswer answer = site.answer(request);
    if (answer.events != nullptr) pages.push_back(answer.events);
    return answer.status;
  };
  for (std::size_t i = 0; i < Feed::kMostOfMember; ++i) EXPECT_EQ(open_page(ada), 200u);
  EXPECT_EQ(open_page(ada), 429u) << "one member does not take all";
  EXPECT_EQ(open_page(log_in({.caller = {.role = Role::kClient, .user = "bob"}, .certificate = ""})), 200u);
  pages.front()->abandon();
  EXPECT_EQ(open_page(ada), 200u);
  ASSERT_TRUE(expelled->expel(Role::kClient, "ada", std::chrono::system_clock::now()).ok());
  EXPECT_EQ(ask("/api/me", ada), 403u) << "expelled";
  site.stop();
}

}  // namespace
}  // namespace tessera::server
