#include "wire/scene_views.h"

#include "absl/strings/str_cat.h"

namespace tessera::wire {

absl::Status keep_view(std::uint32_t view, v1::Scene& scene) {
  if (view > static_cast<std::uint32_t>(scene.views_size())) {
    return absl::InvalidArgumentError(absl::StrCat("there is no view ", view, ": the scene has ",
                                                   1 + scene.views_size(), ", and the first is view 0"));
  }
  if (view > 0) {
    const auto& elements = scene.camera().world_from_camera().elements();
    if (!scene.has_render_origin()) {
      v1::Point3& origin = *scene.mutable_render_origin();
      if (elements.size() == 16)
        origin.set_x(elements[3]), origin.set_y(elements[7]), origin.set_z(elements[11]);
    }
    *scene.mutable_camera() = v1::Camera(scene.views(static_cast<int>(view) - 1));
  }
  scene.clear_views();
  return absl::OkStatus();
}

}  // namespace tessera::wire
