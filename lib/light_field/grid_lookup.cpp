#include "light_field/grid_lookup.h"

#include <algorithm>
#include <cmath>

namespace tessera::light_field {
namespace {

/// Rays through the outermost cameras are in.
constexpr float kSlack = 1e-4f;

float along(const float (&row)[4], const Imath::V3f& v) { return row[0] * v.x + row[1] * v.y + row[2] * v.z; }

void put_row(const Matrix4& m, std::size_t row, double scale, double shift, const Imath::V3d& origin,
             float (&to)[4]) {
  const Imath::V3d axis(m[4 * row], m[4 * row + 1], m[4 * row + 2]);
  for (int i = 0; i < 3; ++i) to[i] = static_cast<float>(scale * axis[i]);
  to[3] = static_cast<float>(scale * (axis.dot(origin) + m[4 * row + 3]) + shift);
}

}  // namespace

GridLookup::GridLookup(const CameraGrid& grid, const Imath::V3d& origin, double focus)
    : first_view_(grid.first_view),
      columns_(grid.columns),
      rows_(grid.rows),
      focus_(static_cast<float>(focus)) {
  const Matrix4 from_world = inverse(grid.world_from_grid).value();
  // A grid of one column is as wide as its spacing, or where that is 0, as anything.
  const double x = grid.spacing_x > 0 ? 1 / grid.spacing_x : 0,
               y = grid.spacing_y > 0 ? 1 / grid.spacing_y : 0;
  put_row(from_world, 0, x, 0.5 * (columns_ - 1), origin, to_column_);
  put_row(from_world, 1, -y, 0.5 * (rows_ - 1), origin, to_row_);
  put_row(from_world, 2, 1, 0, origin, to_z_);
}

bool GridLookup::split(float place, std::uint32_t count, std::uint32_t& index, float& rest) {
  const float last = static_cast<float>(count - 1);
  const float slack = count == 1 ? 0.5f : kSlack;
  if (!(place >= -slack && place <= last + slack)) return false;
  const float inside = std::clamp(place, 0.0f, last);
  index = std::min(static_cast<std::uint32_t>(inside), count == 1 ? 0 : count - 2);
  rest = inside - static_cast<float>(index);
  return true;
}

bool GridLookup::find(const LocalRay& ray, Corners& corners) const {
  corners.z = along(to_z_, ray.origin) + to_z_[3];
  corners.z_step = along(to_z_, ray.direction);
  if (!(corners.z_step > 0)) return false;
  const Imath::V3f place = ray.at(-corners.z / corners.z_step);
  std::uint32_t column = 0, row = 0;
  float u = 0, v = 0;
  if (!split(along(to_column_, place) + to_column_[3], columns_, column, u) ||
      !split(along(to_row_, place) + to_row_[3], rows_, row, v)) {
    return false;
  }
  const std::uint32_t right = columns_ > 1 ? 1 : 0, below = rows_ > 1 ? columns_ : 0;
  const std::uint32_t first = first_view_ + row * columns_ + column;
  corners.views = {first, first + right, first + below, first + below + right};
  corners.weights = {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
  corners.nearest = first + (u > 0.5f ? right : 0) + (v > 0.5f ? below : 0);
  return true;
}

}  // namespace tessera::light_field
