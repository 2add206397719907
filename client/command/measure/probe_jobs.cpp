#include "command/measure/probe_jobs.h"

#include <ImathBox.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "command/jobs/follow.h"
#include "command/render_options.h"
#include "image/image.h"
#include "image/spectral_image.h"
#include "local/bench_scene.h"
#include "local/geometry_query.h"
#include "local/local_farm.h"
#include "local/scene_check.h"
#include "photometry/units/weighting.h"
#include "wire/digest.h"
#include "wire/scene_views.h"

namespace tessera::client {

namespace {

/// Pixels read apart from their neighbours (scene/view/probes.h).
constexpr float kFilterRadius = 0.49f;
/// Bands of jobs of wavelengths: all that V(lambda), V'(lambda) and the melanopic spectrum see.
constexpr int kBands = 47;
constexpr int kFromNm = 360, kToNm = 830;
/// Roulette ends paths long before.
constexpr std::uint32_t kMaxDepth = 4096;

void set_film(std::uint32_t width, std::uint32_t height, float filter_radius, v1::Scene& scene) {
  v1::Film film;
  film.set_width(width), film.set_height(height);
  film.mutable_filter()->set_kind(v1::PixelFilter::BOX);
  film.mutable_filter()->set_radius_x(filter_radius), film.mutable_filter()->set_radius_y(filter_radius);
  scene.mutable_film()->Swap(&film);
}

/// The camera's place in the medium goes on; nothing else of it.
void set_camera(const ProbeJob& job, v1::Scene& scene) {
  v1::Camera camera;
  camera.set_medium(scene.camera().medium());
  *camera.mutable_probes() = job.camera;
  scene.mutable_camera()->Swap(&camera);
  scene.clear_views();
}

/// Settings by which pictures of a scene differ from readings of it.
v1::RenderSettings settings_of(const ProbeJob& job, v1::RenderSettings settings) {
  settings.set_spp(job.spp);
  settings.set_seed(job.seed);
  settings.set_sampler(v1::SAMPLER_SOBOL);
  settings.set_path_sharing(v1::PATH_SHARING_OFF);
  settings.set_reconstruction(v1::RECONSTRUCTION_SAMPLE);
  settings.set_texture_footprint(0);
  settings.set_glass_shadows(v1::GLASS_SHADOWS_TRACED);
  // Rays of meters are aimed: those to the middle of a rectangle meet the edge that its triangles share.
  if (settings.intersection() != v1::INTERSECTION_FAST) settings.set_intersection(v1::INTERSECTION_ROBUST);
  if (settings.color() == v1::COLOR_SPECTRAL) {
    settings.set_sensor("cie1931");
    settings.set_rgb_space(v1::RGB_SPACE_REC709);
    settings.set_white_balance("none");
    settings.set_film(absl::StrCat("spectral:", kBands, ":", kFromNm, "-", kToNm));
  }
  settings.set_exposure("scene");
  if (!job.integrator.empty()) settings.set_integrator(job.integrator);
  if (job.light == ReadLight::kStraight) settings.set_max_depth(0);
  return settings;
}

ChannelValues rgb_values(const RgbPlanes& planes, std::size_t pixel) {
  const double r = planes.r[pixel], g = planes.g[pixel], b = planes.b[pixel];
  return {0.212639 * r + 0.715169 * g + 0.072192 * b, r, g, b};
}

/// Adds what bands of spectral radiance tell.
void add_bands(const Image& image, const std::vector<BandPlane>& bands, std::vector<ChannelValues>& pixels) {
  using photometry::Weighting;
  const std::pair<ReadingChannel, Weighting> channels[] = {
      {ReadingChannel::kRadiant, Weighting::kRadiometric},
      {ReadingChannel::kScotopic, Weighting::kScotopic},
      {ReadingChannel::kMelanopic, Weighting::kMelanopic}};
  for (const auto& [channel, weighting] : channels) {
    for (const BandPlane& band : bands) {
      const double weight = photometry::band_weight(weighting, band.from_nm, band.to_nm);
      const std::vector<float>& values = image.channels[band.channel].values;
      for (std::size_t i = 0; i < pixels.size(); ++i)
        pixels[i][static_cast<std::size_t>(channel)] += weight * static_cast<double>(values[i]);
    }
  }
}

absl::StatusOr<std::vector<ChannelValues>> pixels_of(const Image& image, bool is_spectral) {
  if (image.channels.empty()) return absl::InternalError("a picture of probes is not in memory");
  const RgbPlanes planes = rgb_planes(image);
  std::vector<ChannelValues> pixels(image.pixel_count());
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = rgb_values(planes, i);
  if (!is_spectral) return pixels;
  const auto bands = bands_of(image);
  if (!bands.ok()) return bands.status();
  add_bands(image, *bands, pixels);
  return pixels;
}

}  // namespace

ProbeJobs::ProbeJobs(ImportedScene& scene, ProbeJobOptions options)
    : scene_(scene), options_(std::move(options)) {
  v1::Scene& message = scene_.scene;
  // Media around probes are told from the origin, where the camera's own is known.
  if (!message.camera().has_probes() && (!message.has_render_origin() || message.media_size() > 0))
    *message.mutable_render_origin() = wire::camera_place(message);
  v1::RenderSettings& own = *message.mutable_settings();
  own.clear_noise(), own.clear_layers(), own.clear_film(), own.clear_sensor(), own.clear_white_balance();
  if (!options_.job.settings.has_max_depth()) own.set_max_depth(kMaxDepth);
}

ProbeJobs::~ProbeJobs() = default;

void ProbeJobs::warn(const std::string& warning) {
  if (std::ranges::find(warnings_, warning) == warnings_.end()) warnings_.push_back(warning);
}

/// Meshes of probes go before the scene's blobs, of which the last one may be a patch's.
void ProbeJobs::add_blobs(const std::vector<SceneBlob>& blobs) {
  for (const SceneBlob& blob : blobs) {
    const auto is_it = [&](const SceneBlob& other) { return other.ref.digest() == blob.ref.digest(); };
    if (std::ranges::none_of(scene_.blobs, is_it)) scene_.blobs.insert(scene_.blobs.begin(), blob);
  }
}

absl::StatusOr<ProbePicture> ProbeJobs::render(const ProbeJob& job) {
  add_blobs(job.blobs);
  set_film(job.width, job.height, kFilterRadius, scene_.scene);
  set_camera(job, scene_.scene);
  const v1::RenderSettings settings = settings_of(job, options_.job.settings);
  const auto image = run(settings);
  if (!image.ok()) return image.status();
  auto pixels = pixels_of(*image, settings.color() == v1::COLOR_SPECTRAL);
  if (!pixels.ok()) return pixels.status();
  return ProbePicture{.pixels = *std::move(pixels), .cpu_seconds = cpu_seconds_, .rays = rays_};
}

absl::StatusOr<std::vector<double>> ProbeJobs::render(const PictureJob& job) {
  set_film(job.width, job.height, 0.5f, scene_.scene);
  const std::string medium = scene_.scene.camera().medium();
  *scene_.scene.mutable_camera() = job.camera;
  scene_.scene.mutable_camera()->set_medium(medium);
  scene_.scene.clear_views();
  ProbeJob sampled;
  sampled.spp = job.spp, sampled.seed = job.seed;
  v1::RenderSettings settings = settings_of(sampled, options_.job.settings);
  settings.clear_film();
  const auto image = run(settings);
  if (!image.ok()) return image.status();
  const RgbPlanes planes = rgb_planes(*image);
  std::vector<double> luminances(image->pixel_count());
  for (std::size_t i = 0; i < luminances.size(); ++i) luminances[i] = rgb_values(planes, i)[0];
  return luminances;
}

absl::StatusOr<ProbePicture> ProbeJobs::render(const ProbeJob& job, const v1::Light& light, std::string sky) {
  // The same patch serves all its jobs: the scene is built once for it.
  std::string digest = wire::sha256_hex(sky);
  if (has_patch_ && scene_.blobs.back().ref.digest() == digest) return render(job);
  v1::Scene& scene = scene_.scene;
  scene.clear_lights();
  for (v1::Shape& shape : *scene.mutable_shapes()) shape.clear_area_light();
  for (v1::Object& object : *scene.mutable_objects())
    for (v1::Shape& shape : *object.mutable_shapes()) shape.clear_area_light();
  if (std::exchange(has_patch_, true)) scene_.blobs.pop_back();
  SceneBlob& map = scene_.blobs.emplace_back();
  map.ref.set_digest(std::move(digest));
  map.ref.set_size_bytes(sky.size());
  map.ref.set_path("patch.pfm");
  map.bytes = std::move(sky);
  *scene.add_lights() = light;
  *scene.mutable_lights(0)->mutable_infinite()->mutable_image() = map.ref;
  built_.clear();
  return render(job);
}

absl::Status ProbeJobs::check(const v1::JobSpec& spec) {
  if (!checked_.insert(spec.content().algorithms().integrator()).second) return absl::OkStatus();
  std::vector<SceneFault> faults = find_scene_faults(scene_, &spec);
  for (SceneFault& fault : find_job_faults(scene_, spec)) faults.push_back(std::move(fault));
  return faults.empty() ? absl::OkStatus() : status_of(faults, scene_);
}

absl::Status ProbeJobs::build(const PreparedJob& job) {
  std::shared_ptr<const BuiltScene>& of_integrator = built_[job.spec.content().algorithms().integrator()];
  if (of_integrator != nullptr) return absl::OkStatus();
  if (contents_ == nullptr) contents_ = make_shared_contents();
  auto built = std::make_shared<BuiltScene>();
  built->contents = contents_;
  auto loaded = BenchScene::load(job.spec, job.blobs, options_.threads, built->contents.get(), options_.stop);
  if (!loaded.ok()) return loaded.status();
  for (const std::string& warning : (*loaded)->warnings()) warn(warning);
  built->scene = *std::move(loaded);
  of_integrator = std::move(built);
  return absl::OkStatus();
}

absl::StatusOr<Image> ProbeJobs::run(const v1::RenderSettings& settings) {
  JobSettings asked = options_.job;
  asked.settings = settings;
  const auto prepared = prepare_job(asked, scene_, options_.name);
  if (!prepared.ok()) return absl::InvalidArgumentError(prepared.status().message());
  for (const std::string& warning : (*prepared)->warnings) warn(warning);
  if (absl::Status s = check((*prepared)->spec); !s.ok()) return s;
  if (options_.farm != nullptr) {
    const auto uploaded = options_.farm->upload((*prepared)->blobs, options_.stop, {});
    if (!uploaded.ok()) return uploaded.status();
    return run(**prepared);
  }
  set_local_isa((*prepared)->spec);
  if (absl::Status s = build(**prepared); !s.ok()) return s;
  return run(**prepared);
}

absl::StatusOr<Image> ProbeJobs::run(const PreparedJob& job) {
  std::unique_ptr<LocalFarm> local;
  JobCalls* calls = options_.farm;
  if (calls == nullptr) {
    auto started = LocalFarm::start({.threads = options_.threads,
                                     .isa = job.spec.farm().isa(),
                                     .blobs = job.blobs,
                                     .built = built_[job.spec.content().algorithms().integrator()]});
    if (!started.ok()) return started.status();
    local = *std::move(started);
    calls = &local->calls();
  }
  const auto id = calls->submit(job.spec, {}, options_.stop);
  if (!id.ok()) return id.status();
  auto followed = follow_job(*calls, *id, job.spec, {.quiet = true}, options_.stop);
  if (!followed.ok()) return followed.status();
  const v1::UnitStats& stats = followed->status.stats();
  for (const std::string& warning : stats.warnings()) warn(warning);
  if (followed->status.state() != v1::DONE || followed->images.empty()) {
    const std::string& why = followed->status.error();
    return absl::AbortedError(
        absl::StrCat("job ", *id, " was not finished", why.empty() ? "" : absl::StrCat(": ", why)));
  }
  rays_ = stats.camera_rays() + stats.bounce_rays() + stats.shadow_rays();
  cpu_seconds_ = static_cast<double>(stats.cpu_time().seconds()) + 1e-9 * stats.cpu_time().nanos();
  if (stats.dropped_samples() > 0)
    warn(absl::StrCat(stats.dropped_samples(), " samples were no numbers, and count as black"));
  return std::move(followed->images.front().image);
}

namespace {

void extend_by_row(const Row& row, Imath::Box3d& box) {
  const Columns columns = GeometryQuery::bounds_columns();
  const auto end = [&](std::string_view name) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (columns[i] == name && std::holds_alternative<double>(row[i])) return std::get<double>(row[i]);
    }
    return std::numeric_limits<double>::quiet_NaN();
  };
  const Imath::V3d low(end("low_x"), end("low_y"), end("low_z"));
  if (std::isnan(low.x)) return;
  box.extendBy(low);
  box.extendBy(Imath::V3d(end("high_x"), end("high_y"), end("high_z")));
}

/// Extends the box by a light at a place: one whose kind has a position, or a transform but no sky.
void extend_by_light(const v1::Light& light, Imath::Box3d& box) {
  const auto* const kind =
      light.GetReflection()->GetOneofFieldDescriptor(light, v1::Light::descriptor()->FindOneofByName("kind"));
  if (kind == nullptr || light.has_infinite() || light.has_sky()) return;
  const google::protobuf::Message& message = light.GetReflection()->GetMessage(light, kind);
  const auto field = [&](const char* name) { return message.GetDescriptor()->FindFieldByName(name); };
  Imath::V3d place(0);
  if (const auto* const position = field("position")) {
    v1::Point3 point;
    point.CopyFrom(message.GetReflection()->GetMessage(message, position));
    place = {point.x(), point.y(), point.z()};
  } else if (const auto* const transform = field("world_from_light")) {
    v1::Matrix matrix;
    matrix.CopyFrom(message.GetReflection()->GetMessage(message, transform));
    if (matrix.elements_size() == 16) place = {matrix.elements(3), matrix.elements(7), matrix.elements(11)};
  } else {
    return;
  }
  const auto* const radius_field = field("radius");
  const double radius = radius_field ? message.GetReflection()->GetFloat(message, radius_field) : 0;
  box.extendBy(place - Imath::V3d(radius));
  box.extendBy(place + Imath::V3d(radius));
}

}  // namespace

absl::StatusOr<double> emitted_flux(const ImportedScene& scene, const v1::Scene& lights, int threads) {
  constexpr std::int32_t kRays = 1 << 18;
  ImportedScene part = scene;
  part.scene = lights;
  JobSettings settings;
  settings.settings.set_integrator("volpath");
  settings.settings.set_path_sharing(v1::PATH_SHARING_OFF);
  const auto prepared = prepare_job(settings, part, "flux");
  if (!prepared.ok()) return absl::InvalidArgumentError(prepared.status().message());
  set_local_isa((*prepared)->spec);
  const auto built = BenchScene::load((*prepared)->spec, (*prepared)->blobs, threads);
  if (!built.ok()) return built.status();
  const std::array<double, 3> flux = (*built)->emitted_flux(kRays);
  return 0.212639 * flux[0] + 0.715169 * flux[1] + 0.072192 * flux[2];
}

absl::StatusOr<Ball> ball_around(const ImportedScene& scene, int threads) {
  JobSettings settings;
  settings.settings.set_integrator("volpath");
  settings.settings.set_path_sharing(v1::PATH_SHARING_OFF);
  const auto prepared = prepare_job(settings, scene, "bounds");
  if (!prepared.ok()) return absl::InvalidArgumentError(prepared.status().message());
  set_local_isa((*prepared)->spec);
  GeometryOptions how;
  how.threads = threads;
  const auto query = GeometryQuery::load((*prepared)->spec, (*prepared)->blobs, how);
  if (!query.ok()) return query.status();
  const Columns columns = GeometryQuery::bounds_columns();
  Imath::Box3d box;
  bool is_first = true;
  (*query)->bounds([&](const Row& row) {
    // The first row is that of the scene.
    if (std::exchange(is_first, false)) extend_by_row(row, box);
  });
  for (const v1::Light& light : scene.scene.lights()) extend_by_light(light, box);
  if (box.isEmpty() || !(box.size().length() > 0) || !std::isfinite(box.size().length()))
    return absl::InvalidArgumentError("the scene has no bounds: there is no ball around all of it");
  return Ball{box.center(), box.size().length() / 2};
}

}  // namespace tessera::client
