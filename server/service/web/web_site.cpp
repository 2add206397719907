#include "service/web/web_site.h"

#include <libdeflate.h>

#include <charconv>
#include <future>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "net/x509.h"
#include "service/farm/farm.h"
#include "service/farm/farm_views.h"
#include "service/farm/job_control.h"
#include "service/web/json_text.h"
#include "service/web/pages.h"
#include "service/web/request_guard.h"
#include "telemetry/log.h"

namespace tessera::server {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

constexpr std::chrono::milliseconds kFollowThumbnail{100};
constexpr const char* kService = "/tessera.v1.FarmService/";
constexpr const char* kCookie = "tessera-session=";

HttpAnswer json_answer(const Json& value) {
  return {.body = json_text(value), .headers = {{"Cache-Control", "no-store"}}};
}

HttpAnswer refusal(const absl::Status& status) {
  HttpAnswer answer = json_answer({{"error", std::string(status.message())}});
  answer.status = http_status(status);
  return answer;
}

/// The value of the session's cookie; empty where there is none.
std::string session_of(const HttpRequest& request) {
  for (const auto piece : absl::StrSplit(request.cookie, ';')) {
    const std::string cookie{absl::StripAsciiWhitespace(piece)};
    if (absl::StartsWith(cookie, kCookie)) return cookie.substr(std::string_view{kCookie}.size());
  }
  return "";
}

/// A cookie that scripts cannot read, and that requests of other sites do not carry.
std::string session_cookie(const std::string& session, std::int64_t seconds) {
  return absl::StrCat(kCookie, session, "; Path=/; Max-Age=", seconds, "; HttpOnly; Secure; SameSite=Strict");
}

std::optional<std::uint32_t> number_of(const std::string& text) {
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

/// The parameters of these names, in this order; InvalidArgument for one that is no number.
absl::StatusOr<std::vector<std::uint32_t>> numbers_of(const HttpRequest& request,
                                                      std::initializer_list<const char*> names) {
  std::vector<std::uint32_t> numbers;
  for (const char* name : names) {
    const std::optional<std::uint32_t> number = number_of(request.parameter(name));
    if (!number) return absl::InvalidArgumentError(absl::StrCat(name, " is not a number"));
    numbers.push_back(*number);
  }
  return numbers;
}

std::string text_member(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

Json json_of(const PixelUnits& units) {
  return {{"weights", units.weights},
          {"cd_per_m2", units.cd_per_m2},
          {"radiance", units.radiance},
          {"about", units.about}};
}

/// Waits for a call of the farm.
template <class Call>
absl::Status outcome_of(Call&& call) {
  std::promise<absl::Status> done;
  std::future<absl::Status> status = done.get_future();
  call(done);
  return status.get();
}

/// The name of the call that does the same for the command line; empty: there is none.
std::string method_for(const std::string& action) {
  if (action == "cancel") return "CancelJob";
  if (action == "retry") return "RetryJob";
  if (action == "pause" || action == "resume" || action == "priority") return "AdjustJob";
  return "";
}

void compress(const HttpRequest& request, HttpAnswer& answer) {
  if (answer.body.size() < 1024 || !absl::StrContains(request.accept_encoding, "gzip")) return;
  libdeflate_compressor* const compressor = libdeflate_alloc_compressor(1);
  if (compressor == nullptr) return;
  std::string packed(libdeflate_gzip_compress_bound(compressor, answer.body.size()), '\0');
  packed.resize(libdeflate_gzip_compress(compressor, answer.body.data(), answer.body.size(), packed.data(),
                                         packed.size()));
  libdeflate_free_compressor(compressor);
  if (packed.empty() || packed.size() >= answer.body.size()) return;
  answer.body = std::move(packed);
  answer.headers.emplace_back("Content-Encoding", "gzip");
}

}  // namespace

unsigned http_status(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kOk:
      return 200;
    case absl::StatusCode::kInvalidArgument:
      return 400;
    case absl::StatusCode::kUnauthenticated:
      return 401;
    case absl::StatusCode::kPermissionDenied:
      return 403;
    case absl::StatusCode::kNotFound:
      return 404;
    case absl::StatusCode::kFailedPrecondition:
      return 409;
    case absl::StatusCode::kResourceExhausted:
      return 429;
    case absl::StatusCode::kUnavailable:
      return 503;
    default:
      return 500;
  }
}

WebSite::WebSite(Farm& farm, const Rights& rights, const Expelled& expelled, Members& members,
                 SiteOptions options)
    : farm_(farm),
      rights_(rights),
      expelled_(expelled),
      members_(members),
      options_(std::move(options)),
      pictures_(farm.views()),
      feed_(farm.views(), rights, options_.lines, [this](const Visitor& who) { return is_admitted(who); }) {}

absl::StatusOr<std::string> WebSite::make_token(const Visitor& who, std::chrono::seconds life) {
  return logins_.make_token(who, life, Clock::now());
}

bool WebSite::is_admitted(const Visitor& who) const {
  return !who.caller.role || !expelled_.refuses(*who.caller.role, who.caller.user, who.certificate);
}

absl::StatusOr<Visitor> WebSite::identify(const HttpRequest& request, const std::string& method) const {
  if (!options_.encrypted) return Visitor{};
  std::optional<Visitor> who = logins_.find(session_of(request), Clock::now());
  if (!who && !request.certificate.empty()) {
    const net::Certificate certificate = net::certificate_from_pem(request.certificate);
    if (certificate != nullptr) {
      who.emplace();
      who->certificate = request.certificate;
      who->caller.user = net::name_of(certificate.get());
      for (const std::string& uri : net::uris_of(certificate.get())) {
        if (const auto role = role_of_uri(uri)) who->caller.role = role;
      }
    }
  }
  if (!who || !who->caller.role) return absl::UnauthenticatedError("log in first: tessera token --web");
  const Caller& caller = who->caller;
  if (!is_admitted(*who)) {
    return absl::PermissionDeniedError(
        absl::StrCat("'", caller.user, "' was expelled from the farm: a new certificate is needed"));
  }
  if (!is_allowed(*caller.role, kService + method)) {
    telemetry::log(spdlog::level::warn, {.user = caller.user, .peer = request.peer},
                   "refused: '{}' ({}) called {} of the web page", caller.user, to_string(*caller.role),
                   method);
    return absl::PermissionDeniedError(
        absl::StrCat("this is not for '", caller.user, "' (", to_string(*caller.role), ")"));
  }
  members_.note(*caller.role, caller.user);
  return *who;
}

void WebSite::set_names(std::vector<std::string> names) {
  const std::lock_guard lock(names_mutex_);
  names_ = std::make_shared<const std::vector<std::string>>(std::move(names));
}

std::shared_ptr<const std::vector<std::string>> WebSite::names() const {
  const std::lock_guard lock(names_mutex_);
  return names_;
}

HttpAnswer WebSite::answer(const HttpRequest& request) {
  if (absl::Status status = check_same_site(request, *names()); !status.ok()) return refusal(status);
  HttpAnswer answer;
  if (absl::StartsWith(request.path, "/api/")) {
    answer = answer_api(request);
  } else if (request.method != "GET" && request.method != "HEAD") {
    answer = {.status = 405, .type = "text/plain", .body = "GET only\n"};
  } else if (const std::optional<PageFile> file = page_file(request.path)) {
    answer = {.type = std::string(file->type),
              .body = std::string(file->bytes),
              .headers = {{"Cache-Control", "no-cache"}}};
  } else {
    answer = {.status = 404, .type = "text/plain", .body = "there is nothing here\n"};
  }
  if (answer.events == nullptr) compress(request, answer);
  return answer;
}

HttpAnswer WebSite::answer_api(const HttpRequest& request) {
  const bool reads = request.method == "GET" || request.method == "HEAD";
  if (!reads && request.method != "POST")
    return {.status = 405, .type = "text/plain", .body = "GET and POST only\n"};
  if (request.path == "/api/login") {
    return reads ? refusal(absl::InvalidArgumentError("a login is sent by POST")) : log_in(request);
  }
  if (request.path == "/api/logout" && !reads) return log_out(request);
  const std::string method = reads ? "GetJob" : method_for(request.path.substr(5));
  if (method.empty()) return refusal(absl::NotFoundError("there is no such action"));
  const absl::StatusOr<Visitor> who = identify(request, method);
  if (!who.ok()) return refusal(who.status());
  HttpAnswer answer = reads ? read(request, *who) : change(request, *who);
  answer.member = name_of_member(*who);
  return answer;
}

HttpAnswer WebSite::log_in(const HttpRequest& request) {
  const Json body = Json::parse(request.body, nullptr, /*allow_exceptions=*/false);
  if (!body.is_object()) return refusal(absl::InvalidArgumentError("a login is a JSON object"));
  if (!options_.encrypted) return refusal(absl::FailedPreconditionError("no login is needed here"));
  const absl::StatusOr<std::string> session = logins_.begin(text_member(body, "token"), Clock::now());
  if (!session.ok()) {
    telemetry::log(spdlog::level::warn, {.peer = request.peer}, "login to the web page refused: {}",
                   std::string(session.status().message()));
    return refusal(session.status());
  }
  HttpAnswer answer = json_answer(Json::object());
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(Logins::kSession).count();
  answer.headers.emplace_back("Set-Cookie", session_cookie(*session, seconds));
  const std::optional<Visitor> who = logins_.find(*session, Clock::now());
  if (who) {
    telemetry::log(spdlog::level::info, {.user = who->caller.user, .peer = request.peer},
                   "'{}' logged in to the web page", who->caller.user);
  }
  return answer;
}

HttpAnswer WebSite::log_out(const HttpRequest& request) {
  logins_.end(session_of(request));
  HttpAnswer answer = json_answer(Json::object());
  answer.headers.emplace_back("Set-Cookie", session_cookie("", 0));
  return answer;
}

HttpAnswer WebSite::read(const HttpRequest& request, const Visitor& who) {
  if (request.path == "/api/me") {
    return json_answer({{"user", who.caller.user},
                        {"role", who.caller.role ? to_string(*who.caller.role) : ""},
                        {"version", options_.version},
                        {"login", options_.encrypted},
                        {"log", options_.lines != nullptr},
                        {"time", farm_.clock().wall().count()}});
  }
  if (request.path == "/api/events") return events(request, who);
  if (request.path == "/api/pixels") return pixels(request, who);
  if (request.path == "/api/spectrum") return spectrum(request, who);
  if (request.path == "/api/meter") return meter(request, who);
  if (request.path == "/api/units") return units(request, who);
  if (request.path != "/api/job") return refusal(absl::NotFoundError("there is nothing here"));
  const std::string id = request.parameter("id");
  if (absl::Status status = rights_.check(who.caller, request.peer, id); !status.ok()) return refusal(status);
  const absl::StatusOr<v1::GetJobResponse> job = farm_.views().get_job(id);
  if (!job.ok()) return refusal(job.status());
  return {.body = details_of(*job), .headers = {{"Cache-Control", "no-store"}}};
}

HttpAnswer WebSite::events(const HttpRequest& request, const Visitor& who) {
  FeedRequest asked{.workers = request.query.contains("workers"), .log = request.query.contains("log")};
  if (const std::string job = request.parameter("job"); !job.empty()) {
    if (absl::Status s = rights_.check(who.caller, request.peer, job); !s.ok()) return refusal(s);
    absl::StatusOr<std::shared_ptr<ShownPicture>> picture = pictures_.open(job, request.parameter("layer"));
    if (!picture.ok()) return refusal(picture.status());
    asked.picture = *std::move(picture);
  }
  absl::StatusOr<std::shared_ptr<EventStream>> stream = feed_.open(who, std::move(asked));
  if (!stream.ok()) return refusal(stream.status());
  return {.type = "text/event-stream",
          .body = {},
          .headers = {{"Cache-Control", "no-store"}},
          .events = *std::move(stream)};
}

HttpAnswer WebSite::pixels(const HttpRequest& request, const Visitor& who) {
  const std::string job = request.parameter("job");
  if (absl::Status s = rights_.check(who.caller, request.peer, job); !s.ok()) return refusal(s);
  const auto asked = numbers_of(request, {"level", "x0", "y0", "x1", "y1"});
  if (!asked.ok()) return refusal(asked.status());
  const std::vector<std::uint32_t>& numbers = *asked;
  const absl::StatusOr<std::shared_ptr<ShownPicture>> picture =
      pictures_.open(job, request.parameter("layer"));
  if (!picture.ok()) return refusal(picture.status());
  // Nobody follows thumbnails. Other pages wait behind this one, so the rest is for the next time it asks.
  const bool more = request.query.contains("fresh") &&
                    (*picture)->follow(std::chrono::steady_clock::now() + kFollowThumbnail);
  absl::StatusOr<std::string> bytes =
      (*picture)->part(numbers[0], {numbers[1], numbers[2], numbers[3], numbers[4]});
  if (!bytes.ok()) return refusal(bytes.status());
  return {.type = "application/octet-stream",
          .body = *std::move(bytes),
          .headers = {{"Cache-Control", "no-store"}, {"X-Tessera-More", more ? "1" : "0"}}};
}

HttpAnswer WebSite::spectrum(const HttpRequest& request, const Visitor& who) {
  const std::string job = request.parameter("job");
  if (absl::Status s = rights_.check(who.caller, request.peer, job); !s.ok()) return refusal(s);
  const auto place = numbers_of(request, {"x", "y"});
  if (!place.ok()) return refusal(place.status());
  const absl::StatusOr<std::shared_ptr<ShownPicture>> picture =
      pictures_.open(job, request.parameter("layer"));
  if (!picture.ok()) return refusal(picture.status());
  const auto spectrum = (*picture)->spectrum(place->front(), place->back());
  if (!spectrum.ok()) return refusal(spectrum.status());
  return json_answer(
      {{"nm", spectrum->centres_nm}, {"values", spectrum->values}, {"samples", spectrum->samples}});
}

absl::StatusOr<WebSite::ColorPicture> WebSite::color_picture(const HttpRequest& request, const Visitor& who) {
  const std::string job = request.parameter("job");
  if (absl::Status s = rights_.check(who.caller, request.peer, job); !s.ok()) return s;
  absl::StatusOr<std::shared_ptr<ShownPicture>> picture = pictures_.open_colors(job);
  if (!picture.ok()) return picture.status();
  // Nobody may follow it: the page may show another layer.
  const bool more = (*picture)->follow(std::chrono::steady_clock::now() + kFollowThumbnail);
  return ColorPicture{*std::move(picture), more};
}

HttpAnswer WebSite::meter(const HttpRequest& request, const Visitor& who) {
  const auto place = numbers_of(request, {"x", "y"});
  if (!place.ok()) return refusal(place.status());
  const absl::StatusOr<ColorPicture> colors = color_picture(request, who);
  if (!colors.ok()) return refusal(colors.status());
  const auto light = colors->picture->measure(place->front(), place->back());
  if (!light.ok()) return refusal(light.status());
  const auto reading = [](const LightReading& told) {
    Json json{{"color", told.color},
              {"luminance", told.luminance},
              {"samples", told.samples},
              {"pixels", told.pixels}};
    if (told.error) json["error"] = *told.error;
    return json;
  };
  return json_answer({{"pixel", reading(light->pixel)},
                      {"block", reading(light->block)},
                      {"variance", light->has_variance},
                      {"shares", light->shares},
                      {"more", colors->more},
                      {"units", json_of(colors->picture->units())}});
}

HttpAnswer WebSite::units(const HttpRequest& request, const Visitor& who) {
  const absl::StatusOr<ColorPicture> colors = color_picture(request, who);
  if (!colors.ok()) return refusal(colors.status());
  return json_answer(json_of(colors->picture->units()));
}

HttpAnswer WebSite::change(const HttpRequest& request, const Visitor& who) {
  const Json body = Json::parse(request.body, nullptr, /*allow_exceptions=*/false);
  if (!body.is_object()) return refusal(absl::InvalidArgumentError("a change is a JSON object"));
  const std::string action = request.path.substr(5);
  const std::string id = text_member(body, "id");
  if (absl::Status s = rights_.check(who.caller, request.peer, id); !s.ok()) return refusal(s);
  v1::AdjustJobRequest wanted;
  wanted.set_job_id(id);
  if (action == "pause" || action == "resume") wanted.set_paused(action == "pause");
  if (action == "priority") {
    const auto priority = body.find("priority");
    if (priority == body.end() || !priority->is_number_integer() || priority->get<double>() < -1e9 ||
        priority->get<double>() > 1e9)
      return refusal(absl::InvalidArgumentError("priority is not a number"));
    wanted.set_priority(priority->get<std::int32_t>());
  }
  const absl::Status status = outcome_of([&](std::promise<absl::Status>& done) {
    const auto told = [&done](const absl::StatusOr<v1::JobStatus>& job) { done.set_value(job.status()); };
    if (action == "cancel") return farm_.jobs().cancel(id, told);
    if (action == "retry") return farm_.jobs().retry(id, told, who.caller);
    farm_.jobs().adjust(wanted, told, who.caller);
  });
  if (!status.ok()) return refusal(status);
  telemetry::log(spdlog::level::info, {.job = id, .user = who.caller.user, .peer = request.peer},
                 "job {}: {} from the web page", id, action);
  return json_answer(Json::object());
}

}  // namespace tessera::server
