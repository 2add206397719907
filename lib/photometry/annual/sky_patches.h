// The sky cut into patches, for daylight coefficients.
#pragma once

#include <cstddef>
#include <vector>

#include "photometry/horizon.h"

namespace tessera::photometry {

/// A part of the sky between two altitudes and two azimuths, radians; azimuths from north through east. The
/// last patch is the cap about the zenith.
struct SkyPatch {
  double low = 0, high = 0;
  double azimuth_begin = 0, azimuth_width = 0;

  double solid_angle() const { return azimuth_width * (std::sin(high) - std::sin(low)); }
  /// Integral of the sine of the altitude over the patch: illuminance in lx of an unobstructed horizontal
  /// surface by a patch of 1 cd/m^2.
  double horizontal_integral() const {
    const double sin_low = std::sin(low), sin_high = std::sin(high);
    return azimuth_width * (sin_high * sin_high - sin_low * sin_low) / 2;
  }
  /// In the middle by angles; of the cap, the zenith.
  HorizonDirection middle() const;
  /// The place at shares of the width and, by solid angle, of the height, which are within 0 and 1: even u
  /// and v are even in solid angle.
  HorizonDirection at(double u, double v) const;
};

/// Rows of patches from the horizon up, each from the patch whose middle is north on; patch 0 is the ground.
class SkyPatches {
 public:
  /// The 145 patches of [Tregenza1987], rows of 12 degrees.
  static SkyPatches tregenza() { return SkyPatches(1); }
  /// Those patches cut into `factor` rows of `factor` times as many [Reinhart2001]; a factor of 2 makes 577.
  /// Rows are 90 / (7 factor + 0.5) degrees high, half of that the cap, as in Radiance's reinhartb.cal.
  static SkyPatches reinhart(int factor) { return SkyPatches(factor); }

  /// With the ground, which is number 0.
  std::size_t size() const { return patches_.size() + 1; }
  /// `number`: 1 to size() - 1.
  const SkyPatch& sky(std::size_t number) const { return patches_[number - 1]; }
  /// The patch in which a direction is; 0 below the horizon.
  std::size_t number_of(const HorizonDirection& w) const;
  /// The patches whose middles are nearest to a direction, nearest first.
  std::vector<std::size_t> nearest(const HorizonDirection& w, std::size_t most) const;

 private:
  explicit SkyPatches(int factor);

  std::vector<SkyPatch> patches_;
  std::vector<std::size_t> row_begins_;  // of patches_
  double row_height_ = 0;                // radians
};

}  // namespace tessera::photometry
