// A sky and its sun as maps that renderers look up.
#pragma once

#include <vector>

#include "photometry/sky/sky.h"

namespace tessera::photometry {

/// Direction of a place of the equal-area octahedral map [Clarberg2008], up in the middle, east to the right
/// and north below the middle; `u` and `v` from the upper left corner, within 0 and 1. The horizon is the
/// square whose corners are the middles of the map's sides.
HorizonDirection direction_of_map(double u, double v);

/// Luminances in cd/m^2 of a map of `size` x `size` cells, which have equal solid angles, rows from the top:
/// each is the mean over its cell of sky and ground (not the sun), by points in it, more of them where the
/// sun is and where the horizon goes through. The sky's are then scaled, by some 2e-4 for 128 cells and 1e-5
/// for 512, such that the map's horizontal illuminance is that of the sky.
std::vector<float> sky_map(const Sky& sky, int size);

/// The sun as a column of luminances by the angle from its middle: row r of `rows` at pi r / (rows - 1),
/// linear in between. The first `lit_rows` have `luminance`, the others none.
struct SunColumn {
  int rows = 2;
  int lit_rows = 1;
  double luminance = 0;  // cd/m^2
};

/// The column of a sun that is `degrees` across, 0.01 to 90, and gives that illuminance, lx, of a surface
/// that faces it, exactly. Its luminance falls to zero within a 32nd of its radius, half of it at its border,
/// but for a rounding of the radius by a part in 2 rows.
SunColumn sun_column(double degrees, double normal_illuminance);

}  // namespace tessera::photometry
