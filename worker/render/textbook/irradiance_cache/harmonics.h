// Spherical harmonics over a hemisphere.
#pragma once

#include "render/core/vec.h"
#include "wire/limits.h"
#include "wire/phases/glossy_records.h"

namespace tessera::render::TESSERA_ISA {

using wire::count_of_harmonics;

/// The real spherical harmonics that are even in z, times the square root of 2: these are orthonormal over
/// the hemisphere of z >= 0, and every function of it is a sum of them, continued below as its mirror image.
/// So half of the harmonics of a sphere are enough, and nothing has to fall to zero at the horizon.
class Harmonics {
 public:
  static constexpr int kMostBands = static_cast<int>(wire::kMostGlossyBands);
  static constexpr int kMost = count_of_harmonics(kMostBands);

  /// Bands 0 to `bands` - 1.
  explicit Harmonics(int bands);

  int bands() const { return bands_; }
  int count() const { return count_of_harmonics(bands_); }
  /// All functions at the unit vector `d`, by recurrences [Sloan 2013].
  void evaluate(Vec3 d, Float* values) const;

 private:
  int bands_;
  float first_[kMostBands];           // l = m, over that of m - 1
  float up_[kMostBands][kMostBands];  // factors of the recurrence in l, by m and l
  float down_[kMostBands][kMostBands];
};

}  // namespace tessera::render::TESSERA_ISA
