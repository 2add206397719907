#pragma once

namespace tessera::render {

/// Rows of a 3x4 matrix: maps (x, y, z, 1).
struct Affine {
  float m[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
};

}  // namespace tessera::render
