#include "wire/scene_views.h"

#include "absl/strings/str_cat.h"

namespace tessera::wire {

v1::Point3 camera_place(const v1::Scene& scene) {
  v1::Point3 place;
  const auto& world_from_camera = scene.camera().world_from_camera().elements();
  if (world_from_camera.size() != 16) return place;
  place.set_x(world_from_camera[3]);
  place.set_y(world_from_camera[7]);
  place.set_z(world_from_camera[11]);
  return place;
}

absl::Status keep_view(std::uint32_t view, v1::Scene& scene) {
  if (view > static_cast<std::uint32_t>(scene.views_size())) {
    return absl::InvalidArgumentError(absl::StrCat("there is no view ", view, ": the scene has ",
                                                   1 + scene.views_size(), ", and the first is view 0"));
  }
  if (view > 0) {
    if (!scene.has_render_origin()) *scene.mutable_render_origin() = camera_place(scene);
    *scene.mutable_camera() = v1::Camera(scene.views(static_cast<int>(view) - 1));
  }
  scene.clear_views();
  return absl::OkStatus();
}

}  // namespace tessera::wire
