#include "wire/algorithm_fit.h"

#include <algorithm>

namespace tessera::wire {
namespace {

bool has_portal(const v1::Light& light) { return light.has_infinite() && light.infinite().portal_size() > 0; }

}  // namespace

std::string obstacle_to(const AlgorithmTraits& algorithm, const v1::Scene& scene, bool wants_media) {
  if (algorithm.joins_camera && scene.camera().has_spherical())
    return "needs a perspective or orthographic camera";
  if (algorithm.starts_at_lights && std::ranges::any_of(scene.lights(), has_portal))
    return "cannot begin at a portal";
  if (wants_media && !algorithm.media && scene.media_size() > 0) return "sees no media";
  return "";
}

}  // namespace tessera::wire
