#include "wire/algorithm_fit.h"

#include <algorithm>

namespace tessera::wire {
namespace {

bool has_portal(const v1::Light& light) { return light.has_infinite() && light.infinite().portal_size() > 0; }

bool moves(const v1::Shape& shape) { return shape.world_from_object_end().elements_size() > 0; }

bool has_motion(const v1::Scene& scene) {
  return std::ranges::any_of(scene.shapes(), moves) ||
         std::ranges::any_of(scene.objects(),
                             [](const v1::Object& o) { return std::ranges::any_of(o.shapes(), moves); }) ||
         std::ranges::any_of(scene.instances(), [](const v1::Instance& i) {
           return i.world_from_instance_end().elements_size() > 0;
         });
}

}  // namespace

std::string obstacle_to(const AlgorithmTraits& algorithm, const v1::Scene& scene, bool wants_media) {
  if (algorithm.joins_camera && scene.camera().has_spherical())
    return "needs a perspective or orthographic camera";
  if (algorithm.starts_at_lights && std::ranges::any_of(scene.lights(), has_portal))
    return "cannot begin at a portal";
  if (!algorithm.motion && has_motion(scene)) return "needs shapes that stand still";
  if (wants_media && !algorithm.media && scene.media_size() > 0) return "sees no media";
  return "";
}

}  // namespace tessera::wire
