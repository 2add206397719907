// How a sensor's raster is exposed from time 0, when the first of it is, to 1, when the last of it is.
#pragma once

#include <cstdint>
#include <vector>

namespace tessera::render {

struct ShutterTable {
  /// How far the shutter is open, relative to its mean: linear in between.
  struct Knot {
    float time;
    float openness;
    float cdf;  // integral of the openness from 0 to `time`
  };
  std::vector<Knot> knots;  // the first at 0, the last at 1; empty: open from 0 to 1
  // Rows that are exposed one after the other; 0: all of the raster is exposed at once.
  std::int32_t rows = 0;
  bool from_last = false;  // the last row is the first to be exposed
  bool across = false;     // rows are the raster's columns
  float duration = 1;      // part of the time from 0 to 1 for which a row is exposed
};

}  // namespace tessera::render
