// The matter of patches: how much light they scatter back, and how much they emit.
#pragma once

#include <span>
#include <vector>

#include "render/color/bands.h"
#include "render/integrator/scene_tables.h"
#include "render/textbook/radiosity/patches.h"

namespace tessera::render::TESSERA_ISA::radiosity {

/// Light by bands.
struct Colour {
  float band[kBands] = {0, 0, 0};

  Colour& operator+=(const Colour& other) {
    for (int i = 0; i < kBands; ++i) band[i] += other.band[i];
    return *this;
  }
  friend Colour operator+(Colour a, const Colour& b) { return a += b; }
  friend Colour operator*(Colour a, float s) {
    for (float& value : a.band) value *= s;
    return a;
  }
  friend Colour operator*(Colour a, const Colour& b) {
    for (int i = 0; i < kBands; ++i) a.band[i] *= b.band[i];
    return a;
  }
  float mean() const {
    float sum = 0;
    for (const float value : band) sum += value;
    return sum / kBands;
  }
};

struct Matter {
  Colour reflectance;
  Colour emission;  // radiant exitance, W/m^2
};

/// Means over patches, of four points each where there are textures.
std::vector<Matter> matter_of(const SceneTables& scene, const Surfaces& surfaces,
                              std::span<const Name> patches);

}  // namespace tessera::render::TESSERA_ISA::radiosity
