#include "light_field/refocus.h"

#include <cmath>
#include <vector>

#include "absl/strings/str_cat.h"
#include "light_field/row_work.h"

namespace tessera::light_field {
namespace {

/// Points of the plane of focus that pixels show.
class FocusedPoints {
 public:
  FocusedPoints(const LightField& field, const CameraGrid& grid, const Pinhole& eye, const FocusPlane& focus)
      : eye_(eye), origin_(field.origin()), place_(eye.place()) {
    const Matrix4 from_world = inverse(grid.world_from_grid).value();
    const Imath::V3d x(from_world[0], from_world[1], from_world[2]),
        y(from_world[4], from_world[5], from_world[6]), z(from_world[8], from_world[9], from_world[10]);
    const Imath::V3d from = transformed_point(from_world, place_);
    normal_ = z - focus.slope_x * x - focus.slope_y * y;
    height_ = focus.distance - (from.z - focus.slope_x * from.x - focus.slope_y * from.y);
  }

  /// Measured from the light field's origin. False where the ray does not meet the plane.
  bool find(std::uint32_t x, std::uint32_t y, Imath::V3f& p) const {
    const Imath::V3d direction = eye_.direction(x + 0.5, y + 0.5);
    const double t = height_ / normal_.dot(direction);
    if (!(t > 0) || !std::isfinite(t)) return false;
    p = Imath::V3f(place_ - origin_ + t * direction);
    return true;
  }

 private:
  const Pinhole eye_;
  const Imath::V3d origin_, place_;
  Imath::V3d normal_{0, 0, 1};
  double height_ = 0;
};

}  // namespace

absl::StatusOr<CameraGrid> only_grid(const Manifest& manifest) {
  const Arrangement& arrangement = manifest.arrangement;
  if (arrangement.grids.size() == 1) return arrangement.grids.front();
  return absl::InvalidArgumentError(
      absl::StrCat("an aperture lies in the plane of a grid of cameras, and this set (", arrangement.kind,
                   ") has ", arrangement.grids.empty() ? "none" : "several", "; two-plane sets have one"));
}

Pinhole camera_of_grid(const Manifest& manifest, const CameraGrid& grid, double x, double y) {
  const View& first = manifest.views[grid.first_view];
  // The window of the first camera on the second plane, which is that of all.
  const ImageWindow at_first = window_of(first.camera, manifest.width, manifest.height);
  const double first_x = -0.5 * (grid.columns - 1) * grid.spacing_x - x;
  const double first_y = 0.5 * (grid.rows - 1) * grid.spacing_y - y;
  const double shift_x = first_x / grid.focus, shift_y = first_y / grid.focus;
  Pinhole camera;
  camera.world_from_camera = grid.world_from_grid;
  const Imath::V3d place = transformed_point(grid.world_from_grid, {x, y, 0});
  camera.world_from_camera[3] = place.x, camera.world_from_camera[7] = place.y;
  camera.world_from_camera[11] = place.z;
  set_window({at_first.x0 + shift_x, at_first.x1 + shift_x, at_first.y0 + shift_y, at_first.y1 + shift_y},
             manifest.width, manifest.height, camera);
  return camera;
}

absl::StatusOr<Picture> refocus(LightField& field, const Aperture& aperture, const FocusPlane& focus,
                                int threads) {
  const Manifest& manifest = field.manifest();
  const auto grid = only_grid(manifest);
  if (!grid.ok()) return grid.status();
  if (!(focus.distance > 0) || !std::isfinite(focus.distance))
    return absl::InvalidArgumentError("what is in focus lies before the cameras, at a distance above 0");
  const auto weights = camera_weights(*grid, aperture);
  if (!weights.ok()) return weights.status();
  const Pinhole eye = camera_of_grid(manifest, *grid, aperture.x, aperture.y);
  const FocusedPoints points(field, *grid, eye, focus);
  Picture picture{.width = manifest.width, .height = manifest.height, .pixels = {}, .known = {}};
  picture.pixels.resize(std::size_t{picture.width} * picture.height);
  picture.known.resize(picture.pixels.size());  // the sum of weights, to begin with
  std::vector<Imath::V3f> focused(picture.pixels.size(), Imath::V3f(NAN));
  for_each_row(picture.height, threads, [&](std::uint32_t y) {
    for (std::uint32_t x = 0; x < picture.width; ++x)
      static_cast<void>(points.find(x, y, focused[std::size_t{y} * picture.width + x]));
  });
  for (const auto& [view, weight] : *weights) {
    ViewPixels& pixels = field.pixels(view);
    const Projection& projection = field.projection(view);
    for_each_row(picture.height, threads, [&, w = weight](std::uint32_t y) {
      for (std::uint32_t x = 0; x < picture.width; ++x) {
        const std::size_t pixel = std::size_t{y} * picture.width + x;
        Seen seen;
        const Imath::V3f at = projection.homogeneous(focused[pixel]);
        if (!(at.z > 0) || !pixels.shows(at.x / at.z, at.y / at.z)) continue;
        if (!pixels.look(at.x / at.z, at.y / at.z, seen)) continue;
        picture.pixels[pixel] += w * seen.rgba;
        picture.known[pixel] += w;
      }
    });
    pixels.release();
  }
  picture.rays = picture.pixels.size();
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    float& known = picture.known[i];
    if (known > 0) {
      picture.pixels[i] = picture.pixels[i] / known;
      known = 1;
    } else {
      ++picture.missing;
    }
  }
  return picture;
}

}  // namespace tessera::light_field
