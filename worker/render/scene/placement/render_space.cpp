#include "render/scene/placement/render_space.h"

#include <cmath>

#include "render/scene/values/located.h"

namespace tessera::render {

RenderSpace render_space_about(Imath::V3d origin) {
  return {origin, Transform::translation({-origin.x, -origin.y, -origin.z})};
}

absl::StatusOr<Imath::V3d> render_origin(const v1::Scene& scene) {
  const auto world_from_camera = Transform::from_proto(scene.camera().world_from_camera());
  if (!world_from_camera.ok()) return located(world_from_camera.status(), "camera");
  const v1::Point3& own = scene.render_origin();
  const Imath::V3d origin =
      scene.has_render_origin() ? Imath::V3d{own.x(), own.y(), own.z()} : world_from_camera->apply({0, 0, 0});
  for (const double x : {origin.x, origin.y, origin.z}) {
    if (!std::isfinite(x)) return absl::InvalidArgumentError("the scene's render_origin is not finite");
  }
  return origin;
}

}  // namespace tessera::render
