#include "render/scene/view/view.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "render/scene/view/focus.h"
#include "render/scene/view/lens_faults.h"
#include "render/scene/view/probes.h"
#include "render/scene/view/sensitivity.h"
#include "render/sensor/footprint_record.h"
#include "wire/exposure.h"
#include "wire/film_sensor.h"
#include "wire/pixel_filter.h"
#include "wire/scene_views.h"

namespace tessera::render {

absl::StatusOr<PixelFilterRecord> build_filter(const v1::PixelFilter& filter) {
  FilterSpec spec;
  switch (filter.kind()) {
    case v1::PixelFilter::TRIANGLE:
      spec.kind = FilterKind::kTriangle;
      break;
    case v1::PixelFilter::GAUSSIAN:
      spec.kind = FilterKind::kGaussian;
      break;
    case v1::PixelFilter::MITCHELL:
      spec.kind = FilterKind::kMitchell;
      break;
    case v1::PixelFilter::LANCZOS:
      spec.kind = FilterKind::kLanczos;
      break;
    default:
      break;
  }
  const auto positive_or = [](float x, float otherwise) { return x > 0 && std::isfinite(x) ? x : otherwise; };
  const wire::FilterRadius radius = wire::radius_of(filter);
  spec.radius_x = radius.x, spec.radius_y = radius.y;
  spec.sigma = positive_or(filter.sigma(), spec.sigma);
  spec.tau = positive_or(filter.tau(), spec.tau);
  if (filter.b() != 0 || filter.c() != 0) spec.b = filter.b(), spec.c = filter.c();
  if (!std::isfinite(spec.b) || !std::isfinite(spec.c) || std::max(spec.radius_x, spec.radius_y) > 1000) {
    return absl::InvalidArgumentError("film: the pixel filter's parameters are not usable");
  }
  return PixelFilterRecord::build(spec);
}

std::optional<SensorRecord> check_camera(const v1::Camera& camera, const std::string& place,
                                         const v1::JobSpec& job, const Settings& settings,
                                         const RenderSpace& space, const BlobSource& blobs,
                                         FaultList& faults) {
  if (settings.aovs.has(wire::HitAov::kMotion) && wire::sees_all_around(camera)) {
    faults.add(
        camera, place,
        absl::InvalidArgumentError("it sees all around, so that aov 'motion' has no film to move over"));
  }
  if (const std::vector<LensFault> of_lens = lens_faults_of(camera); !of_lens.empty()) {
    for (const LensFault& fault : of_lens)
      faults.add(*fault.element, place, absl::InvalidArgumentError(fault.message), fault.field);
    return std::nullopt;
  }
  auto sensor = build_sensor(camera, {job.view().width(), job.view().height()}, space, *settings.algorithm,
                             settings.spectral,
                             {blobs ? &blobs : nullptr, camera.has_focus_point(), settings.light_into_lens});
  if (!faults.add(camera, place, sensor.status())) return std::nullopt;
  return *std::move(sensor);
}

float check_exposure(const v1::Scene& scene, const v1::Camera& camera, const std::string& place,
                     const v1::JobSpec& job, FaultList& faults) {
  const auto exposure = wire::film_exposure(scene.film(), job.view().exposure());
  if (!faults.add(scene.film(), "film", exposure.status())) return 1;
  const auto scale = wire::exposure_scale(*exposure, camera);
  if (!faults.add(camera, place, scale.status())) return 1;
  const auto single = static_cast<float>(*scale);
  if (!std::isfinite(single))
    faults.add(scene.film(), "film", absl::InvalidArgumentError("the exposure is not finite"));
  if (single == 0 && exposure->photographic)
    faults.add(scene.film(), "film",
               absl::InvalidArgumentError("the exposure is so short that all is black"));
  return single;
}

absl::Status set_view(const v1::Scene& scene, const v1::JobSpec& job, const Settings& settings,
                      const RenderSpace& space, const BlobSource& blobs, SceneTables& tables) {
  FaultList faults(1);
  set_view(scene, job, settings, space, blobs, tables, faults);
  return faults.first();
}

void set_view(const v1::Scene& scene, const v1::JobSpec& job, const Settings& settings,
              const RenderSpace& space, const BlobSource& blobs, SceneTables& tables, FaultList& faults) {
  if (auto sensor = check_camera(scene.camera(), "camera", job, settings, space, blobs, faults)) {
    const std::int32_t medium = tables.sensor.medium;  // belongs to the content
    tables.sensor = *std::move(sensor);
    tables.sensor.medium = medium;
    tables.sensor.response.exposure = check_exposure(scene, scene.camera(), "camera", job, faults);
  } else {
    faults.add(scene.film(), "film", wire::film_exposure(scene.film(), job.view().exposure()).status());
  }
  const auto check_film = [&](const absl::Status& status) {
    return faults.add(scene.film(), "film", status);
  };
  if (scene.camera().has_probes()) check_film(check_probe_film(scene.film().filter(), job));
  if (job.view().reconstruction() == v1::RECONSTRUCTION_SCATTER)
    check_film(wire::check_scattering(scene.film().filter()));
  tables.footprint = footprint_of(tables.sensor, job.view().texture_footprint());
  auto filter = build_filter(scene.film().filter());
  if (check_film(filter.status())) tables.filter = *std::move(filter);
  Response& response = tables.sensor.response;
  if (settings.spectral) {
    const auto asked = wire::film_sensor_of(job.view());
    auto sensitivity = asked.ok() ? build_sensitivity(*asked, scene.film()) : asked.status();
    if (check_film(sensitivity.status())) response.sensitivity = *std::move(sensitivity);
  }
  tables.sampler = settings.sampler;
  tables.max_depth = settings.max_depth;
  tables.own = settings.own;
  tables.aovs = settings.aovs;
  for (int i = 0; i < 3; ++i) tables.render_origin[i] = static_cast<float>(space.origin[i]);
  tables.irradiance_cache = settings.irradiance_cache;
  tables.radiosity = settings.radiosity;
  tables.photon = settings.photon;
  tables.metropolis = settings.metropolis;
}

absl::Status focus_view(const v1::Scene& scene, const v1::JobSpec& job, const BlobSource& blobs,
                        const SceneArrays& arrays, const RayQuery& rays, SceneTables& tables) {
  if (!scene.camera().has_focus_point()) return absl::OkStatus();
  v1::Camera camera = scene.camera();
  if (auto s = focus_on_point(tables.sensor, arrays, rays, camera); !s.ok()) return s;
  const auto origin = render_origin(scene);
  if (!origin.ok()) return origin.status();
  const Settings settings = read_settings(job);
  FaultList faults(1);
  auto sensor = check_camera(camera, "camera", job, settings, render_space_about(*origin), blobs, faults);
  if (!sensor) return faults.first();
  sensor->medium = tables.sensor.medium;
  sensor->response = std::move(tables.sensor.response);
  tables.sensor = *std::move(sensor);
  tables.footprint = footprint_of(tables.sensor, job.view().texture_footprint());
  return absl::OkStatus();
}

}  // namespace tessera::render
