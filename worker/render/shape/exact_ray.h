#pragma once

namespace tessera::render {

/// One ray whose origin and direction (of any length) are not rounded to floats.
struct ExactRay {
  double o[3], d[3];

  double at(int axis, double t) const { return o[axis] + t * d[axis]; }
};

}  // namespace tessera::render
