#include "command/report/camera_facts.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "import/geometry/transform.h"
#include "optics/lens_system.h"
#include "wire/lens_message.h"
#include "wire/viewpoint.h"

namespace tessera::client {
namespace {

RowMatrix attribute_of(const Imath::M44d& matrix) {
  RowMatrix result;
  std::copy_n(matrix.getValue(), result.m.size(), result.m.begin());
  return result;
}

struct Screen {
  double x_min = -1, x_max = 1, y_min = -1, y_max = 1;
};

/// The part of the plane z = 1 that the display window shows.
Screen screen_of(const v1::Camera& camera, const Window& display) {
  if (camera.screen_window_size() == 4) {
    return {camera.screen_window(0), camera.screen_window(1), camera.screen_window(2),
            camera.screen_window(3)};
  }
  const double aspect = double{static_cast<double>(display.width())} / display.height();
  return aspect > 1 ? Screen{-aspect, aspect, -1, 1} : Screen{-1, 1, -1 / aspect, 1 / aspect};
}

/// NDC from camera space; third and fourth coordinates so that it can be inverted.
std::optional<Imath::M44d> projection_of(const v1::Camera& camera, const Window& display) {
  // A distorted film is no projection.
  if ((!camera.has_perspective() && !camera.has_orthographic()) || camera.has_distortion())
    return std::nullopt;
  const Screen screen = screen_of(camera, display);
  const double width = screen.x_max - screen.x_min, height = screen.y_max - screen.y_min;
  if (camera.has_orthographic()) {
    return Imath::M44d(1 / width, 0, 0, 0, 0, -1 / height, 0, 0, 0, 0, 1, 0, -screen.x_min / width,
                       screen.y_max / height, 0, 1);
  }
  const double half_side = std::tan(camera.perspective().fov_degrees() * std::numbers::pi / 360);
  const double near = camera.near_clip() > 0 ? camera.near_clip() : 1;
  const wire::WindowShift shift = wire::window_shift(camera);
  return Imath::M44d(1 / (width * half_side), 0, 0, 0, 0, -1 / (height * half_side), 0, 0,
                     -(screen.x_min + shift.x / half_side) / width,
                     (screen.y_max + shift.y / half_side) / height, 1, 1, 0, 0, -near, 0);
}

/// By OpenEXR's standard names, which say metres for the focus and millimetres for the focal length.
void add_lens_facts(const v1::LensCamera& camera, Image& image) {
  std::vector<optics::Fault> faults;
  const std::optional<optics::LensSystem> lens = wire::lens_system_of(camera, faults);
  if (!lens) return;  // a camera that no worker takes
  if (!camera.lens().name().empty()) image.metadata["lensModel"] = camera.lens().name();
  image.metadata["effectiveFocalLength"] = static_cast<float>(lens->paraxial().focal_length());
  image.metadata["aperture"] = static_cast<float>(lens->use().f_number);
  image.metadata["focus"] = static_cast<float>(lens->focus_distance() / 1000);
}

}  // namespace

void add_camera_facts(const v1::Camera& camera, Image& image) {
  if (camera.has_lens()) add_lens_facts(camera.lens(), image);
  if (!camera.view_name().empty()) image.metadata["view"] = camera.view_name();
  const std::optional<Imath::M44d> camera_from_world =
      inverse(matrix_of(wire::camera_from_viewpoint(camera)) * matrix_of(camera.world_from_camera()));
  if (!camera_from_world) return;
  image.metadata["worldToCamera"] = attribute_of(*camera_from_world);
  if (const auto projection = projection_of(camera, image.display))
    image.metadata["worldToNDC"] = attribute_of(*camera_from_world * *projection);
}

}  // namespace tessera::client
