// How points of the scene come to lie on a film, in homogeneous coordinates. Lights see the scene as cameras
// do: a face of a shadow map is a film too.
#pragma once

#include "render/core/affine_data.h"
#include "render/sensor/sensor_record.h"

namespace tessera::render::TESSERA_ISA {

/// Each row maps (x, y, z, 1) of render space to one number.
struct Projection {
  double film_x[4], film_y[4];  // pixels from the upper left corner; times the depth where `perspective`
  double depth[4];              // render-space units along the axis of the view
  bool perspective = true;
  float nearest = 0;  // least depth that is seen
  int width = 0, height = 0;
  int reach = 1;  // pixels by which a sample may lie off its pixel
};

/// The projection of a pinhole or orthographic camera as it stands when the shutter opens. `least_depth`,
/// above 0, is for perspective ones that clip nothing themselves.
Projection projection_of(const SensorRecord& sensor, float least_depth, int reach);

/// A projection in single precision, from another space than render space and to another film.
struct Rows {
  float x[4], y[4], depth[4];
};

/// `render_from_space` null: render space. The film's origin is moved to the pixel corner (`left`, `top`),
/// and a pixel has `units` units.
Rows rows_of(const Projection& projection, const Affine* render_from_space, int left, int top, int units);

}  // namespace tessera::render::TESSERA_ISA
