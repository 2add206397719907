// Sensors that see all around, as kernels read them beyond the scale of their raster.
#pragma once

#include <cstdint>

namespace tessera::render {

/// The cell of a cube map's raster that a face lies in, and the face's axes in sensor space: a place of the
/// cell sees forward + u right + v up, with u from -1 at the left edge to 1, v from -1 at the lower edge
/// to 1.
struct CubeFace {
  float column = 0, row = 0;
  float right[3] = {1, 0, 0}, up[3] = {0, 1, 0}, forward[3] = {0, 0, 1};
};

struct CubeRecord {
  std::int32_t columns = 1, rows = 1, faces = 1;
  bool equiangular = false;
  CubeFace face[6];
};

/// One eye of omnidirectional stereo [Peleg, Ben-Ezra & Pritch 2001]: rays leave a circle about the sensor at
/// right angles to its radius.
struct CircleOfEyes {
  float radius = 0;  // of the circle, sensor space; above 0 for eyes to the right of where they look
  float inverse_convergence = 0;  // 1 / distance from the middle at which both eyes' rays meet; 0: never
  // Latitudes, in radians, between which the radius goes to zero by a quarter of a cosine; beyond, it is.
  float merge_from = 4, merge_to = 5;
};

struct PanoramaTable {
  CubeRecord cube;    // kCubeMap
  CircleOfEyes eyes;  // kPanorama
};

}  // namespace tessera::render
