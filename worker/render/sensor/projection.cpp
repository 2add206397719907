#include "render/sensor/projection.h"

#include <algorithm>

#include "render/core/vec64.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// The row of the inverse of [x y z | place] that gives the coordinate along x, given y and z.
void inverse_row(const vec64::Vec& x, const vec64::Vec& y, const vec64::Vec& z, const vec64::Vec& place,
                 double (&row)[4]) {
  const vec64::Vec across = vec64::cross(y, z);
  const double volume = vec64::dot(x, across);
  for (std::size_t i = 0; i < 3; ++i) row[i] = across[i] / volume;
  row[3] = -(row[0] * place[0] + row[1] * place[1] + row[2] * place[2]);
}

}  // namespace

Projection projection_of(const SensorRecord& sensor, float least_depth, int reach) {
  const float* const m = sensor.steps.empty() ? sensor.render_from_sensor.m : sensor.steps.front().m;
  const auto column = [&](int c) { return vec64::Vec{m[c], m[4 + c], m[8 + c]}; };
  const vec64::Vec right = column(0), up = column(1), forward = column(2), place = column(3);
  double x[4], y[4], z[4];
  inverse_row(right, up, forward, place, x);
  inverse_row(up, forward, right, place, y);
  inverse_row(forward, right, up, place, z);

  Projection result;
  result.perspective = raster_of(sensor.kind).shape == RasterShape::kPlane;
  const double unit_of_depth = vec64::length(forward);
  for (int i = 0; i < 4; ++i) {
    // film = (place - offset) / scale, with place = (x / z, y / z) or (x, y).
    const double one = result.perspective ? z[i] : i == 3 ? 1 : 0;
    const double scale = result.perspective ? unit_of_depth : 1;
    result.film_x[i] = (x[i] - sensor.offset_x * one) / sensor.scale_x * scale;
    result.film_y[i] = (y[i] - sensor.offset_y * one) / sensor.scale_y * scale;
    result.depth[i] = z[i] * unit_of_depth;
  }
  result.nearest = result.perspective ? std::max(sensor.near_clip, least_depth) : sensor.near_clip;
  result.width = sensor.width;
  result.height = sensor.height;
  result.reach = reach;
  return result;
}

Rows rows_of(const Projection& projection, const Affine* render_from_space, int left, int top, int units) {
  double rows[3][4];
  for (int i = 0; i < 4; ++i) {
    const double one = projection.perspective ? projection.depth[i] : i == 3 ? 1 : 0;
    rows[0][i] = (projection.film_x[i] - left * one) * units;
    rows[1][i] = (projection.film_y[i] - top * one) * units;
    rows[2][i] = projection.depth[i];
  }
  Rows result;
  float* const to[3] = {result.x, result.y, result.depth};
  for (int r = 0; r < 3; ++r) {
    for (int i = 0; i < 4; ++i) {
      double value = rows[r][i];
      if (render_from_space != nullptr) {
        const float* const m = render_from_space->m;
        value = i == 3 ? rows[r][3] : 0;
        for (int k = 0; k < 3; ++k) value += rows[r][k] * m[4 * k + i];
      }
      to[r][i] = static_cast<float>(value);
    }
  }
  return result;
}

}  // namespace tessera::render::TESSERA_ISA
