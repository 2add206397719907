// What chains bring to the film: each path by how likely a chain is there.
#pragma once

#include <vector>

#include "render/color/spectrum.h"
#include "render/film/film.h"

namespace tessera::render::TESSERA_ISA {

class ChainSplats {
 public:
  /// The factor of all that is added from here on.
  void set_scale(float scale) { scale_ = scale; }

  /// The light of a path that is as bright as said, over its brightness, times `weight`.
  void add(float x, float y, const float* light, float brightness, float weight) {
    if (!(brightness > 0) || !(weight > 0)) return;
    const float scale = weight * scale_ / brightness;
    const auto band = [&](int number) {
      return band_mean(number, [&](int lane) { return light[lane] * scale; });
    };
    splats_.push_back({x, y, {band(0), band(1), band(2)}, 0});
  }

  void flush(Film& film) {
    film.splat(splats_);
    splats_.clear();
  }

 private:
  float scale_ = 0;
  std::vector<Splat> splats_;
};

}  // namespace tessera::render::TESSERA_ISA
