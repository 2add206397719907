// A scene's lights as a preview takes them: lamps at points, the brightest with shadows, and ambient light.
#pragma once

#include <cstdint>
#include <vector>

#include "render/color/spectrum.h"
#include "render/integrator/scene_tables.h"

namespace tessera::render::TESSERA_ISA {

/// A light that shines from a point, or an emitting surface, or a part of one, taken for a patch at its
/// centre.
struct Lamp {
  std::int32_t light = -1;  // index in LightTable: sampled as it is; -1: a patch
  std::int32_t shape = -1;  // the shape that emits the light and does not shadow it; -1: none
  bool at_infinity = false;
  float place[3] = {0, 0, 0};  // render space
  float axis[3] = {0, 0, 1};   // unit, in which the light travels mostly; at infinity: all of it
  float cone = 0;              // angle about it, radians, beyond which there is no light
  double power = 0;            // mean of R, G and B, as LightSource::power
  // Patches
  float radiance[kBands] = {0, 0, 0};
  float flat_area = 0;   // area seen along the axis, less round_area
  float round_area = 0;  // area seen from anywhere, on average over directions [Cauchy 1832]
  bool two_sided = false;
  float radius = 0;  // radius of a disk of that area; lights with an extent but no surface: their own
};

inline constexpr std::size_t kMostLamps = 32;
inline constexpr std::size_t kMostShadowMaps = 4;

struct Lighting {
  std::vector<Lamp> lamps;  // the most powerful first; kMostLamps at most
  // Irradiance from all around, by the normal: spherical harmonics up to the second order, with the weights
  // of the cosine [Ramamoorthi & Hanrahan 2001].
  float ambient[9][kBands] = {};

  /// Ambient irradiance on a surface with unit normal `n`.
  Spectrum ambient_irradiance(Vec3 n) const;
};

/// Light that comes from lamps straight is left to them. Ambient are the environments, what the lamps beyond
/// kMostLamps send out, and what all lamps' light becomes in a closed sphere about the scene of which half is
/// reflected.
Lighting lighting_of(const SceneTables& scene);

/// Light of a lamp at 16 points.
struct LampLight {
  Vec3 wi;              // unit, towards it
  Spectrum irradiance;  // irradiance of a surface across wi, unless something is between
  Float most;  // no reflection of it is brighter: its radiance; infinite for lights without an extent
  Mask lit;
};
LampLight light_of(const SceneTables& scene, const Lamp& lamp, Vec3 p, Mask active);

}  // namespace tessera::render::TESSERA_ISA
