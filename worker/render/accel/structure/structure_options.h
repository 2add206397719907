// How structures of the courses are built.
#pragma once

#include <stop_token>

namespace tessera::render {

/// Cells of a grid for each primitive: three along each axis for one that it would have to itself.
inline constexpr double kGridDensity = 27;

struct StructureOptions {
  int threads = 1;
  bool wide = false;  // sixteen boxes at a step, where a structure can (BVH); else as it is read
  double grid_density = kGridDensity;  // cells a primitive
  bool shadow_cache = false;           // shadow rays are tested against the last occluder first
  std::stop_token stop = {};
};

}  // namespace tessera::render
