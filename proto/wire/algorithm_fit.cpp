#include "wire/algorithm_fit.h"

#include <algorithm>

namespace tessera::wire {
namespace {

bool has_portal(const v1::Light& light) { return light.has_infinite() && light.infinite().portal_size() > 0; }

bool turns_to_rays(const v1::Shape& shape) {
  return shape.has_curves() && shape.curves().kind() != v1::Curves::RIBBON;
}

bool moves(const v1::Shape& shape) { return shape.world_from_object_end().elements_size() > 0; }

template <class Property>
bool has_shape(const v1::Scene& scene, Property property) {
  return std::ranges::any_of(scene.shapes(), property) ||
         std::ranges::any_of(scene.objects(), [&](const v1::Object& object) {
           return std::ranges::any_of(object.shapes(), property);
         });
}

bool any_moves(const google::protobuf::RepeatedPtrField<v1::Instance>& instances) {
  return std::ranges::any_of(
      instances, [](const v1::Instance& i) { return i.world_from_instance_end().elements_size() > 0; });
}

bool has_motion(const v1::Scene& scene) {
  return has_shape(scene, moves) || any_moves(scene.instances()) ||
         std::ranges::any_of(scene.objects(),
                             [](const v1::Object& object) { return any_moves(object.instances()); });
}

}  // namespace

std::string obstacle_to(const AlgorithmTraits& algorithm, const v1::Scene& scene, bool wants_media) {
  if (algorithm.projects_points && scene.camera().has_spherical())
    return "needs a perspective or orthographic camera";
  if (algorithm.starts_at_lights && std::ranges::any_of(scene.lights(), has_portal))
    return "cannot begin at a portal";
  if (algorithm.starts_at_lights && has_shape(scene, turns_to_rays))
    return "cannot light flat curves and cylinders";
  if (!algorithm.motion && has_motion(scene)) return "needs shapes that stand still";
  if (wants_media && !algorithm.media && scene.media_size() > 0) return "sees no media";
  return "";
}

}  // namespace tessera::wire
