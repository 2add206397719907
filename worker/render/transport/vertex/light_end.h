// The end of a path on a light, as weights of multiple importance sampling see it.
#pragma once

#include "render/light/light.h"
#include "render/transport/vertex/partial_weights.h"

namespace tessera::render::TESSERA_ISA {

/// Densities of 16 such ends and of the edge to the vertex beside them. What the three ways to make them have
/// in common is left out: the inverse square of the edge, and for lights at infinity nothing.
struct LightEnd {
  Float sampled;  // sampled as a light that shines on that vertex
  Float emitted;  // a path from the light, by UnitArea, still without the cosine at the vertex
  Float hit;  // met by a path from the eye, still without the density of its direction; 0 for delta lights

  /// Sums at the first vertex of a path from the light, met under this cosine.
  TESSERA_INLINE PartialWeights first_vertex(Float cosine) const {
    const Float scale = 1.0f / max(emitted * max(cosine, 1e-9f), 1e-37f);
    return {power(sampled * scale), power(hit * scale)};
  }
  /// The weight of light sampling at a vertex that is met under this cosine along the light. Scattering gives
  /// that direction with density `forward`, and paths from the light go `back` along the path from the eye.
  TESSERA_INLINE Float sampling_weight(const PartialWeights& eye, Float cosine, Float forward, Float back,
                                       Float merged) const {
    const Float scale = 1.0f / max(sampled, 1e-37f);
    return weight_of_way(power(forward * hit * scale), eye.ways(emitted * cosine * scale, back, merged));
  }
  /// The weight of a path from the eye that hit the light; `eye` before it arrived there.
  TESSERA_INLINE Float hit_weight(const PartialWeights& eye) const {
    const Float scale = 1.0f / max(hit, 1e-37f);
    return weight_of_way(Float(0.0f),
                         fma(power(emitted * scale), eye.rest, power(sampled * scale) * eye.last));
  }
};

/// Lanes whose light is one of those that only light sampling and emission find.
Mask delta_lights(const LightTable& table, Int light, Mask active);

/// The end at `point` of light `light`, from where light leaves at `time` along the unit `direction`, which
/// has this cosine (positive where it shines) with its surface; 1 without one. Light sampling gives it with
/// density `pdf`, by solid angle and over all lights, from this far away.
LightEnd light_end(const LightTable& table, Int light, Float time, Float pdf, Vec3 point, Float cosine,
                   Vec3 direction, Float distance_squared, Mask active);

/// The density of light sampling at `from`, over all lights, for the direction `wi` that meets the light at
/// `point` with unit geometric normal `normal`; of lights with one point or direction that of the light
/// alone.
Float sampling_density(const LightTable& table, Int light, const Receiver& from, Vec3 wi, Vec3 point,
                       Vec3 normal, Mask active);

}  // namespace tessera::render::TESSERA_ISA
