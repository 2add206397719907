// Sensors for tests of where rays go: a film of 40 x 20 pixels that stands askew.
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "render/sensor/lens_table.h"
#include "render/sensor/sensor.h"

namespace tessera::render::TESSERA_ISA {

inline constexpr int kWidthPixels = 40, kHeightPixels = 20, kMiddleX = kWidthPixels / 2,
                     kMiddleY = kHeightPixels / 2;

/// 40 x 20 pixels of [-2, 2] x [-1, 1], turned, and scaled by `scale` where told.
inline SensorRecord sensor_of(SensorKind kind, float lens_radius, float scale) {
  SensorRecord c;
  c.kind = lens_radius > 0 ? with_lens(kind) : kind;
  // x right, y up, z forward: a rotation about (1, 1, 1), which permutes the axes.
  for (float& m : c.render_from_sensor.m) m = 0;
  c.render_from_sensor.m[2] = c.render_from_sensor.m[4] = c.render_from_sensor.m[9] = scale;
  c.width = kWidthPixels;
  c.height = kHeightPixels;
  c.scale_x = 0.1f, c.offset_x = -2;
  c.scale_y = -0.1f, c.offset_y = 1;
  c.lens_radius = lens_radius;
  c.focal_distance = 3;
  return c;
}

/// Brightness of a picture of 6 x 4 cells, of which two are nearly dark.
inline const std::vector<float> kCells = {1,     0.05f, 2, 1,    3, 0.5f, 0.5f, 1, 4,     1,     2, 2,
                                          0.05f, 3,     1, 2.5f, 1, 1,    1.5f, 2, 0.25f, 0.75f, 1, 2};
struct Lens {
  float radius = 0;
  std::optional<ApertureRecord> aperture = {};
  bool picture = false;
};
inline SensorRecord sensor_of(SensorKind kind, const Lens& lens, float scale) {
  SensorRecord c = sensor_of(kind, lens.radius, scale);
  if (!lens.aperture) return c;
  auto table = std::make_shared<LensTable>();
  table->aperture = *lens.aperture;
  if (lens.picture) table->picture.density = Piecewise2d::build(kCells, 6, 4);
  c.lens = std::move(table);
  return c;
}

}  // namespace tessera::render::TESSERA_ISA
