// Veach's weights of multiple importance sampling for paths of two ends, in closed form a vertex.
//
// A path of k edges can be made in many ways: so many of its vertices from the light, the rest from the eye.
// The weight of one way is its density over the sum of all densities, each squared (power heuristic)
// [Veach 1997, section 10.2]. Relative to the way at hand, the ways with a vertex less on one side form a
// chain of ratios, and its sum can be kept along the subpath: what is missing at its end is only how the
// other side would sample its last two vertices [Georgiev 2012; van Antwerpen 2011].
//
// Densities are nominal: what every way has in common (transmittance of media, Russian roulette, choices of
// delta lobes) is left out everywhere. Weights still add up to one on every path, so nothing is biased.
//
// The sums are fourth powers of lengths: areas are counted in a UnitArea, so that floats hold them in scenes
// of any size.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "render/core/wide.h"
#include "render/light/light_table.h"

namespace tessera::render::TESSERA_ISA {

/// A ratio of densities as the power heuristic counts it.
TESSERA_INLINE Float power(Float ratio) { return sqr(ratio); }

/// The area that densities by area are multiplied by, and squared lengths divided by: a power of two next to
/// the radius of the scene, so that ratios keep their bits. What grows as the fourth power of a scene's size
/// grows as the square in these units, and as little in parts of it that are as small as 1.
struct UnitArea {
  float size, inverse;

  explicit TESSERA_INLINE UnitArea(const LightTable& lights) {
    constexpr std::uint32_t kExponent = 0x7f800000, kOne = 0x3f800000;
    // Neither end of the exponents has an inverse.
    const float radius = std::fmin(std::fmax(lights.scene_radius, 1e-30f), 1e30f);
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(radius) & kExponent;
    size = std::bit_cast<float>(bits);
    inverse = std::bit_cast<float>(2 * kOne - bits);
  }
};

/// Sums over the ways to make a subpath with less of it sampled from its own side. In the words of
/// [Georgiev 2012] d^VCM and d^VC.
struct PartialWeights {
  Float last;  // the join of the vertex with the one before it, without the density of the vertex itself
  Float rest;  // sum of all joins further back, without that density and that of the vertex before

  /// The subpath has met its next vertex, this far away, squared, in unit areas, and under this cosine with
  /// its surface (1 in media).
  TESSERA_INLINE void arrive(Float distance_squared, Float cosine) {
    const Float slope = power(1.0f / max(cosine, 1e-9f));
    last *= power(distance_squared) * slope;
    rest *= slope;
  }

  /// Sum over these ways, where the other side would sample the vertex with `density` by unit area (by volume
  /// in media), and go back from it along the subpath with `back` by solid angle. `merged` is what merging
  /// with the vertex adds: the power of how many photons it would meet (photon_map/), 0 where there are none.
  TESSERA_INLINE Float ways(Float density, Float back, Float merged) const {
    return power(density) * (fma(power(back), rest, last) + merged);
  }

  /// The subpath goes on from the vertex in a direction that has this cosine with its surface (1 in media),
  /// chosen with `forward` by solid angle; the other side, coming from there, would go `back`. Perfect
  /// mirrors and glass are chosen alike from both sides, and nothing is joined to them.
  TESSERA_INLINE PartialWeights scattered(Float cosine, Float forward, Float back, Float merged,
                                          Mask specular) const {
    const Float inverse = power(1.0f / select(specular, 1.0f, max(forward, 1e-30f)));
    const Float before = select(specular, rest, fma(power(back), rest, last) + merged);
    return {select_or_zero(~specular, inverse), power(cosine) * inverse * before};
  }
};

/// The weight of a way, given the sums over the ways with fewer vertices from the light and from the eye.
TESSERA_INLINE Float weight_of_way(Float from_light, Float from_eye) {
  const Float sum = 1.0f + from_light + from_eye;
  // A way whose sum overflows, or is NaN, is next to impossible here and likely elsewhere.
  return select_or_zero(is_finite(sum), 1.0f / sum);
}

/// Returns the factor that makes light weighed by `weight` the light that the way finds by itself.
TESSERA_INLINE Float inverse_of(Float weight) {
  const Mask some = weight > 1e-37f;
  return select_or_zero(some, 1.0f / select(some, weight, 1.0f));
}

}  // namespace tessera::render::TESSERA_ISA
