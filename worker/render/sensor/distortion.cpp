#include "render/sensor/distortion.h"

#include "render/core/wide_memory.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// A difference of places, and its derivatives for steps of one cell.
struct Difference {
  Float x, y, x_by_s, x_by_t, y_by_s, y_by_t;
};

/// Cubics that are one in their value, or slope, at one end of a cell, and zero in all others; `slope`:
/// derivatives.
struct HermiteWeights {
  Float value[2], tangent[2], value_slope[2], tangent_slope[2];

  explicit HermiteWeights(Float t) {
    const Float t2 = t * t, rest = 1.0f - t;
    value[1] = t2 * (3.0f - 2.0f * t);
    value[0] = 1.0f - value[1];
    tangent[0] = t * rest * rest;
    tangent[1] = t2 * (t - 1.0f);
    value_slope[1] = 6.0f * t * rest;
    value_slope[0] = -value_slope[1];
    tangent_slope[0] = rest * (1.0f - 3.0f * t);
    tangent_slope[1] = t * (3.0f * t - 2.0f);
  }
};

/// The value of a smooth table's coordinate, and its derivatives by s and t.
struct Smooth {
  Float value = Float(0.0f), by_s = Float(0.0f), by_t = Float(0.0f);

  void add(const Wide4<float>& node, const HermiteWeights& s, int i, const HermiteWeights& t, int j) {
    const Float along_s = fma(node.c[0], s.value[i], node.c[1] * s.tangent[i]),
                cross_s = fma(node.c[2], s.value[i], node.c[3] * s.tangent[i]),
                along_slope = fma(node.c[0], s.value_slope[i], node.c[1] * s.tangent_slope[i]),
                cross_slope = fma(node.c[2], s.value_slope[i], node.c[3] * s.tangent_slope[i]);
    value = value + fma(along_s, t.value[j], cross_s * t.tangent[j]);
    by_s = by_s + fma(along_slope, t.value[j], cross_slope * t.tangent[j]);
    by_t = by_t + fma(along_s, t.value_slope[j], cross_s * t.tangent_slope[j]);
  }
};

Difference smooth_difference(const DistortionTable& table, Int node, Float s, Float t) {
  const HermiteWeights along(s), down(t);
  Smooth x, y;
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      const Int at = (node + (j * (table.grid.columns + 1) + i)) * DistortionTable::kSmoothNode;
      x.add(gather4(table.nodes.data(), at, Mask::all()), along, i, down, j);
      y.add(gather4(table.nodes.data() + 4, at, Mask::all()), along, i, down, j);
    }
  }
  return {x.value, y.value, x.by_s, x.by_t, y.by_s, y.by_t};
}

Difference bilinear_difference(const DistortionTable& table, Int node, Float s, Float t) {
  const auto corner = [&](int component, int column, int row) {
    const Int at = (node + (row * (table.grid.columns + 1) + column)) * DistortionTable::kBilinearNode;
    return gather(table.nodes.data() + component, at);
  };
  Float value[2], by_s[2], by_t[2];
  for (int c = 0; c < 2; ++c) {
    const Float upper = corner(c, 0, 0), lower = corner(c, 0, 1);
    const Float upper_step = corner(c, 1, 0) - upper, lower_step = corner(c, 1, 1) - lower;
    const Float above = fma(s, upper_step, upper), below = fma(s, lower_step, lower);
    value[c] = lerp(t, above, below);
    by_s[c] = lerp(t, upper_step, lower_step);
    by_t[c] = below - above;
  }
  return {value[0], value[1], by_s[0], by_t[0], by_s[1], by_t[1]};
}

/// The cell of a place, its part of the cell's sides, and whether it is within the grid; else it is the one
/// next to the place.
struct Cell {
  Int column, row;
  Float s, t;
  Mask inside;
};
Cell cell_of(const PlaceGrid& grid, Vec2 place) {
  const auto columns = static_cast<float>(grid.columns), rows = static_cast<float>(grid.rows);
  const Float x = (place.x - grid.first_x) * grid.per_x, y = (place.y - grid.first_y) * grid.per_y;
  const Float in_x = clamp(select_or_zero(x == x, x), 0.0f, columns),
              in_y = clamp(select_or_zero(y == y, y), 0.0f, rows);
  const Int column = min(to_int(in_x), grid.columns - 1), row = min(to_int(in_y), grid.rows - 1);
  return {column, row, in_x - to_float(column), in_y - to_float(row), (x == in_x) & (y == in_y)};
}

struct Linearized {
  Vec2 place;                         // undistorted
  Float xx, xy, yx, yy, determinant;  // xy: derivative of x by y
  Mask inside;
};
Linearized linearize(const DistortionTable& table, Vec2 film) {
  const Cell cell = cell_of(table.grid, film);
  const Int node = cell.row * (table.grid.columns + 1) + cell.column;
  const Difference d = table.smooth ? smooth_difference(table, node, cell.s, cell.t)
                                    : bilinear_difference(table, node, cell.s, cell.t);
  Linearized at;
  at.place = {film.x + d.x, film.y + d.y};
  at.xx = fma(d.x_by_s, Float(table.grid.per_x), Float(1.0f)), at.xy = d.x_by_t * table.grid.per_y;
  at.yx = d.y_by_s * table.grid.per_x, at.yy = fma(d.y_by_t, Float(table.grid.per_y), Float(1.0f));
  at.determinant = difference_of_products(at.xx, at.yy, at.xy, at.yx);
  at.inside = cell.inside;
  return at;
}

/// Moved onto the table.
Vec2 within(const PlaceGrid& grid, Vec2 place) {
  const auto limit = [](Float x, float first, float per, std::int32_t cells) {
    const float last = first + static_cast<float>(cells) / per;
    return first < last ? clamp(x, first, last) : clamp(x, last, first);
  };
  return {limit(place.x, grid.first_x, grid.per_x, grid.columns),
          limit(place.y, grid.first_y, grid.per_y, grid.rows)};
}

}  // namespace

MovedPlace undistort(const DistortionTable& table, Vec2 film) {
  const Linearized at = linearize(table, film);
  return {at.place, at.determinant, at.inside & (at.determinant > 0.0f)};
}

MovedPlace distort(const DistortionTable& table, Vec2 undistorted) {
  const Cell start = cell_of(table.start_grid, undistorted);
  const Int entry = (start.row * table.start_grid.columns + start.column) * 2;
  Vec2 film{gather(table.starts.data(), entry), gather(table.starts.data() + 1, entry)};
  Mask found = Mask::none();
  Float area(1.0f);
  constexpr int kSteps = 12;
  for (int i = 0; i < kSteps && !all(found); ++i) {
    const Linearized at = linearize(table, film);
    const Float inverse = 1.0f / select(abs(at.determinant) > 1e-12f, at.determinant, Float(1e-12f));
    const Float rest_x = undistorted.x - at.place.x, rest_y = undistorted.y - at.place.y;
    const Float step_x = difference_of_products(at.yy, rest_x, at.xy, rest_y) * inverse,
                step_y = difference_of_products(at.xx, rest_y, at.yx, rest_x) * inverse;
    film = within(table.grid, {film.x + step_x, film.y + step_y});
    // The rest after a step is of the order of its square. Steps that lead off the table stay large.
    found = max(abs(step_x), abs(step_y)) <= table.near;
    area = at.determinant;
  }
  return {film, area, found & (area > 0.0f)};
}

PlaceSlopes slopes_near(const DistortionTable& table, Vec2 undistorted) {
  const Cell cell = cell_of(table.start_grid, undistorted);
  const std::int32_t stride = table.start_grid.columns + 1;
  const Int node = cell.row * stride + cell.column;
  PlaceSlopes sum{Float(0.0f), Float(0.0f), Float(0.0f), Float(0.0f)};
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      const Float weight = (i == 0 ? 1.0f - cell.s : cell.s) * (j == 0 ? 1.0f - cell.t : cell.t);
      const Wide4<float> at = gather4(table.slopes.data(), (node + (j * stride + i)) * 4, Mask::all());
      sum.xx = fma(weight, at.c[0], sum.xx), sum.xy = fma(weight, at.c[1], sum.xy);
      sum.yx = fma(weight, at.c[2], sum.yx), sum.yy = fma(weight, at.c[3], sum.yy);
    }
  }
  return sum;
}

}  // namespace tessera::render::TESSERA_ISA
