// Harmonics of incoming radiance and their gradients, from samples of a hemisphere.
#pragma once

#include <vector>

#include "render/color/bands.h"
#include "render/color/spectrum.h"
#include "render/textbook/irradiance_cache/harmonics.h"

namespace tessera::render::TESSERA_ISA {

/// Radiance and distance in the cells of a hemisphere: rings of equal solid angle from the normal to the
/// horizon, each cut into sectors of equal azimuth.
class RadianceHemisphere {
 public:
  /// About `samples` cells, which are about as wide as high in the mean.
  RadianceHemisphere(int samples, int bands);

  int cells() const { return rings_ * sectors_; }
  /// The direction within cell `cell` that `u`, uniform in the unit square, stands for, about +z.
  Vec3 direction(Int cell, Vec2 u) const;
  /// The radiance from 16 cells from `first` on, seen along `directions`, and how far away what it comes from
  /// is: infinite where nothing is. Cells beyond the last are ignored.
  void set(int first, Vec3 directions, Vec3 radiance, Float distance);

  struct Estimate {
    // One block a function: value, change along x and along y, each with all bands, as in GlossyRecords.
    std::vector<float> numbers;
    double mean_distance;  // harmonic
    double nearest;
  };
  /// The functions' integrals are means over the directions seen. They change as the borders between cells
  /// move, each as fast as the nearer of its two sides makes it [Ward & Heckbert 1992; Krivanek, Gautron,
  /// Bouatouch & Pattanaik 2005].
  Estimate estimate() const;

 private:
  struct Cells;
  void add(const Cells& cells, std::vector<Float>& sums) const;

  const int rings_, sectors_;
  const Harmonics harmonics_;
  std::vector<float> radiance_[kBands], distance_, direction_[3];  // padded to whole packets
};

}  // namespace tessera::render::TESSERA_ISA
