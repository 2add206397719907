// Which cameras of a grid are around a ray.
#pragma once

#include <array>
#include <cstdint>

#include "light_field/light_field.h"

namespace tessera::light_field {

/// A ray in single precision, measured from the light field's origin.
struct LocalRay {
  Imath::V3f origin, direction;

  Imath::V3f at(float t) const { return origin + t * direction; }
};

/// The four cameras about the place where a ray crosses the plane of a grid, with bilinear weights.
struct Corners {
  std::array<std::uint32_t, 4> views;
  std::array<float, 4> weights;
  std::uint32_t nearest;  // view
  float z, z_step;        // of the ray in the grid's space: z + t z_step
};

class GridLookup {
 public:
  /// `focus`: z of the second plane.
  GridLookup(const CameraGrid& grid, const Imath::V3d& origin, double focus);

  /// False where the ray crosses the plane beside the cameras, or against their directions.
  bool find(const LocalRay& ray, Corners& corners) const;
  /// Ray parameter of the second plane.
  float at_focus(const Corners& corners) const { return (focus_ - corners.z) / corners.z_step; }
  float focus() const { return focus_; }

 private:
  static bool split(float place, std::uint32_t count, std::uint32_t& index, float& rest);

  const std::uint32_t first_view_, columns_, rows_;
  const float focus_;
  float to_column_[4], to_row_[4], to_z_[4];  // of points; without the last one, of directions
};

}  // namespace tessera::light_field
