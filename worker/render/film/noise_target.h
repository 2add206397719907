// How much noise a picture may have.
#pragma once

#include <cstdint>

namespace tessera::render {

struct NoiseTarget {
  double noise = 0;           // root of the picture's relMSE that is wanted; 0: pixels take all samples
  std::uint32_t samples = 0;  // a pixel, at most
};

}  // namespace tessera::render
