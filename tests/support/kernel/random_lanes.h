// Random numbers for kernels, from a seed of one's own.
#pragma once

#include <random>

#include "render/core/wide.h"

namespace tessera::render::TESSERA_ISA {

class RandomLanes {
 public:
  explicit RandomLanes(unsigned seed) : engine_(seed) {}

  /// Uniform in [low, high), every lane by itself.
  Float operator()(float low = 0, float high = 1) {
    alignas(64) float lanes[kWidth];
    for (float& x : lanes) x = low + (high - low) * static_cast<float>(engine_() >> 8) * 0x1p-24f;
    return Float::load(lanes);
  }

 private:
  std::mt19937 engine_;
};

}  // namespace tessera::render::TESSERA_ISA
