// Irradiance and its gradients from samples of a hemisphere [Ward & Heckbert 1992].
#pragma once

#include <vector>

#include "render/color/bands.h"
#include "render/core/vec.h"
#include "render/textbook/irradiance_cache/record_site.h"

namespace tessera::render::TESSERA_ISA {

/// Radiance and distance in the cells of a hemisphere: rings of equal cosine-weighted solid angle from the
/// normal to the horizon, each cut into sectors of equal azimuth.
class Hemisphere {
 public:
  /// About `samples` cells, which are about as wide as high: pi times as many sectors as rings.
  explicit Hemisphere(int samples);

  int cells() const { return rings_ * sectors_; }
  /// The direction within cell `cell` that `u`, uniform in the unit square, stands for, about +z.
  Vec3 direction(Int cell, Vec2 u) const;
  /// The radiance from a cell, and how far away what it comes from is: infinite where nothing is.
  void set(int cell, const float (&radiance)[kBands], float distance);

  struct Estimate {
    double irradiance[kBands];
    double rotation[kBands][2];     // about the axes x and y
    double translation[kBands][2];  // along them
    double mean_distance;           // harmonic
    double nearest;
  };
  Estimate estimate() const;

 private:
  std::size_t at(int ring, int sector) const { return static_cast<std::size_t>(ring * sectors_ + sector); }
  void add_cell(int ring, int sector, Estimate& sum) const;

  const int rings_, sectors_;
  std::vector<float> radiance_[kBands], distance_;
  // Sines and cosines of the azimuths at the beginning and the middle of sectors, and the mean tangents of
  // rings.
  std::vector<float> border_x_, border_y_, middle_x_, middle_y_, tangent_;
};

}  // namespace tessera::render::TESSERA_ISA
