#include "local/scene_check.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "local/scene_blobs.h"
#include "render/build/shape/shape_faults.h"
#include "render/build/view/sensor.h"
#include "wire/algorithm_fit.h"

namespace tessera::client {

std::vector<SceneFault> find_shape_faults(const ImportedScene& imported) {
  std::vector<const SceneBlob*> blobs;
  for (const SceneBlob& blob : imported.blobs) blobs.push_back(&blob);
  const SceneBlobs source(blobs);
  std::vector<SceneFault> faults;
  for (render::ShapeFault& fault : render::find_shape_faults(
           imported.scene, [&](const std::string& digest) { return source.bytes(digest); },
           Diagnostics::kMaxErrors))
    faults.push_back({fault.shape, std::move(fault.place), std::move(fault.message)});
  return faults;
}

std::vector<SceneFault> find_job_faults(const v1::Scene& scene, const v1::JobSpec& job) {
  const v1::Algorithms& algorithms = job.content().algorithms();
  std::vector<SceneFault> faults;
  for (wire::Obstacle& obstacle : wire::find_obstacles(algorithms, scene, Diagnostics::kMaxErrors)) {
    faults.push_back({obstacle.element, std::move(obstacle.place),
                      absl::StrCat("integrator '", algorithms.integrator(), "' ", obstacle.reason)});
  }
  if (!faults.empty()) return faults;
  const auto origin = render::render_origin(scene);
  absl::Status status = origin.status();
  if (origin.ok()) {
    status = render::build_sensor(scene.camera(), {job.view().width(), job.view().height()},
                                  render::render_space_about(*origin),
                                  *wire::find_algorithm(algorithms.integrator()))
                 .status();
  }
  if (!status.ok()) {
    const std::string message{absl::StripPrefix(status.message(), "camera: ")};
    faults.push_back({&scene.camera(), "camera", message});
  }
  return faults;
}

}  // namespace tessera::client
