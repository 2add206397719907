// Lights that shine from a point.
#pragma once

#include <cmath>

#include "render/core/constants.h"
#include "render/light/light_access.h"
#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {

/// Directions in which light leaves, and the inverse of their density by solid angle.
struct Directions {
  Vec3 w;
  Float inverse_density;
};

/// Intensity is what arrives at distance 1. A model says in which directions there is any, and how bright it
/// is there.
class PositionalLight : public LightModel {
 public:
  PositionalLight() : LightModel({.delta = true}) {}

  /// A point that shines equally in all directions, with the model's profile.
  LightSample sample(const LightTable& table, Int light, const Receiver& from, Vec2 u,
                     Mask active) const override;
  /// Turns `s`, light that is the same in all directions, into what the model sends along -s.wi: scales its
  /// radiance, and makes it invalid where there is none.
  virtual void apply_profile(const LightLanes&, LightSample&) const {}

  Float pdf(const LightTable&, Int, const Receiver&, Vec3, Vec3, Vec3, Mask) const final { return 0.0f; }

  Emission emit(const LightTable& table, Int light, Float, Vec2, Vec2 u, Mask active) const final {
    const LightLanes lanes{table, light, active};
    const Directions chosen = directions(lanes, u);
    const Vec3 position = lanes.field3(&LightRecord::position);
    const float distance = looking_distance(table);
    const LightSample seen = sample(table, light, fma(chosen.w, Float(distance), position), u, active);
    return {position, no_offset(), chosen.w, seen.radiance * (chosen.inverse_density * (distance * distance)),
            active & seen.valid};
  }

  EmissionDensity emission_density(const LightTable& table, Int light, Float, Vec3, Float, Vec3 direction,
                                   Mask active) const final {
    return {Float(1.0f), direction_density({table, light, active}, direction)};
  }

  /// Bounds in which a light without a normal counts four times.
  LightBounds bounds(const LightTable&, const LightRecord& light) const override {
    LightBounds b;
    b.intensity = 4 * mean_radiance(light);
    b.add(vec64::vec(light.position));
    b.angle = std::numbers::pi;
    b.reach = std::numbers::pi / 2;
    return b;
  }

 private:
  /// The distance from which emit() looks at the light: 1, or the size of scenes beside which 1 would vanish.
  static float looking_distance(const LightTable& table) {
    constexpr float kLarge = 4096;
    return table.scene_radius <= kLarge ? 1 : std::exp2(std::floor(std::log2(table.scene_radius)));
  }

 protected:
  /// Chooses directions by solid angle; these all around.
  virtual Directions directions(const LightLanes&, Vec2 u) const {
    return {square_to_sphere(u), Float(4 * kPi)};
  }
  /// The density with which directions() gives `w`.
  virtual Float direction_density(const LightLanes&, Vec3) const { return Float(kInv4Pi); }
};

}  // namespace tessera::render::TESSERA_ISA
