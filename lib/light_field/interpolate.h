// New pictures of a light field, by rays of any camera.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "light_field/light_field.h"

namespace tessera::light_field {

/// World space; the direction has any length. Without one, there is no ray, and the pixel is empty.
struct Ray {
  Imath::V3d origin{0, 0, 0}, direction{0, 0, 0};
};

enum class Interpolation : std::uint8_t {
  kQuadrilinear,  // of the sixteen rays around, by the second plane of grids [Levoy & Hanrahan 1996]
  kDepth,     // the same, where views see the surface that the ray meets [Gortler et al. 1996, section 3.3]
  kLumigraph  // unstructured lumigraph rendering [Buehler et al. 2001]
};

struct PictureRequest {
  std::uint32_t width = 0, height = 0;
  /// Fills the rays of a row of pixels; called from several threads at once.
  std::function<void(std::uint32_t y, std::span<Ray> row)> rays;
  Interpolation by = Interpolation::kDepth;
  /// Distance from grids' planes to the second plane; absent: each grid's own.
  std::optional<double> focus;
  int threads = 1;
};

/// Rows from the top.
struct Picture {
  std::uint32_t width = 0, height = 0;
  std::vector<Rgba> pixels;
  std::vector<float> known;  // 1 where the light field has the ray, else 0, and the pixel is 0
  std::uint64_t rays = 0, missing = 0;
};

/// InvalidArgument where the views stand in no grid, and the interpolation needs one.
absl::Status check_interpolation(const Arrangement& arrangement, Interpolation by);

/// Looks up all rays. Bits do not depend on threads. Rays that no view sees, or that lie in damaged tiles,
/// are missing (LightField::damage() names these). Errors are those of check_interpolation().
absl::StatusOr<Picture> interpolate(LightField& field, const PictureRequest& request);

}  // namespace tessera::light_field
