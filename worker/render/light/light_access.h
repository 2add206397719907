// Shared by the light models: reading records, and the end of a shadow ray.
#pragma once

#include "render/core/constants.h"
#include "render/light/light.h"

namespace tessera::render::TESSERA_ISA {

/// LightKind a lane.
TESSERA_INLINE Int kind_of(const LightTable& table, Int light, Mask active) {
  static_assert(sizeof(LightKind) == sizeof(std::int32_t));
  const auto* kinds = reinterpret_cast<const std::int32_t*>(&table.lights.data()->kind);
  return gather(kinds, light * static_cast<std::int32_t>(sizeof(LightRecord) / 4), active);
}

/// Lanes whose light comes from all around.
TESSERA_INLINE Mask environment_lanes(const LightTable& table, Int light, Mask active) {
  const Int kind = kind_of(table, light, active);
  return active & ((kind == static_cast<std::int32_t>(LightKind::kInfinite)) |
                   (kind == static_cast<std::int32_t>(LightKind::kMovingInfinite)));
}

/// The record of all active lanes, if they have one light.
TESSERA_INLINE const LightRecord* common_light(const LightTable& table, Int light, Mask active) {
  const std::optional<std::int32_t> one = common_value(light, active);
  return one ? &table.lights[static_cast<std::size_t>(*one)] : nullptr;
}

/// The records of 16 lights.
struct LightLanes {
  const LightTable& table;
  Int light;
  Mask active;
  Float time = Float(0.0f);                                        // when light leaves it
  const LightRecord* common = common_light(table, light, active);  // read once then, not gathered

  TESSERA_INLINE Float field(float LightRecord::*member) const {
    return common != nullptr ? Float(common->*member)
                             : gather_member(table.lights.data(), member, light, active);
  }
  TESSERA_INLINE Int field(std::int32_t LightRecord::*member) const {
    return common != nullptr ? Int(common->*member)
                             : gather_member(table.lights.data(), member, light, active);
  }
  /// Elements first, first + 1 and first + 2 of an array.
  template <std::size_t N>
  TESSERA_INLINE Vec3 field3(float (LightRecord::*member)[N], int first = 0) const {
    if (common != nullptr) {
      const float* const row = (common->*member) + first;
      return {Float(row[0]), Float(row[1]), Float(row[2])};
    }
    // A row of four: none of the arrays ends the record.
    const Float4 row = gather4((table.lights.data()->*member) + first,
                               light * static_cast<std::int32_t>(sizeof(LightRecord) / 4), active);
    return {select_or_zero(active, row.c[0]), select_or_zero(active, row.c[1]),
            select_or_zero(active, row.c[2])};
  }
  TESSERA_INLINE Color radiance() const {
    const Vec3 rgb = field3(&LightRecord::radiance);
    const Float components[kBands] = {rgb.x, rgb.y, rgb.z};
    return color_of([&](int band) { return components[band]; });
  }
  /// A direction of render space, turned into the space of a kSpot, kProjection or kGoniometric.
  TESSERA_INLINE Vec3 to_light(Vec3 w) const {
    return {dot(field3(&LightRecord::vertices, 0), w), dot(field3(&LightRecord::vertices, 3), w),
            dot(field3(&LightRecord::vertices, 6), w)};
  }
  /// The light's texture at `uv` for lanes in `wanted` that have one, else 1.
  Color texture_at(Vec2 uv, Mask wanted) const;
  /// An area light shines from the front of its surface, or from both sides.
  TESSERA_INLINE Mask shines_towards(Vec3 normal, Vec3 wo) const {
    return active & ((dot(normal, wo) > 0.0f) | (field(&LightRecord::two_sided) != 0));
  }
};

TESSERA_INLINE LightSample select(Mask m, const LightSample& a, const LightSample& b) {
  return {select(m, a.wi, b.wi),
          select(m, a.distance, b.distance),
          select(m, a.radiance, b.radiance),
          select(m, a.pdf, b.pdf),
          (m & a.valid) | and_not(b.valid, m),
          (m & a.delta) | and_not(b.delta, m),
          {select(m, a.barycentric.x, b.barycentric.x), select(m, a.barycentric.y, b.barycentric.y)},
          select(m, a.cosine, b.cosine)};
}

TESSERA_INLINE Vec3 no_offset() { return {Float(0.0f), Float(0.0f), Float(0.0f)}; }

/// The texture of area lights at points of their surfaces at `time`, 1 for lights that have none.
Color emission_texture(const LightTable& table, Int light, Float time, Vec3 point, Vec2 barycentric,
                       Mask active);

/// Length of shadow rays to lights at infinity: beyond any scene, and finite when squared.
inline constexpr float kInfiniteDistance = 1e18f;

TESSERA_INLINE Float max_abs(Vec3 v) { return max(max(abs(v.x), abs(v.y)), abs(v.z)); }

/// How far off the plane through `point` a ray from `reference`, `distance` away, may really end, for
/// rounding at either end. `extent` is the emitter's. Each coordinate at the light is off by at most eight
/// roundings (shape/surface.cpp), and so is the origin that the ray starts from.
TESSERA_INLINE Float ray_end_error(Vec3 reference, Vec3 point, Float extent, Float distance) {
  constexpr float kCoordinateError = 0x1p-21f * 1.7320508f;  // along the normal
  return (max_abs(reference) + max_abs(point) + extent + distance) * kCoordinateError;
}

/// A shadow ray's length to a point at `distance` of a surface met under `cos_light` (positive).
TESSERA_INLINE Float shortened(Float distance, Float error, Float cos_light) {
  return max(distance - error / max(cos_light, 1e-6f), 0.0f);
}

/// The sample of an area light whose point was chosen with density `pdf_area`.
TESSERA_INLINE LightSample sample_from_point(const LightLanes& lanes, Vec3 reference, Vec3 point, Vec3 normal,
                                             Float pdf_area, Float extent) {
  const Vec3 to_light = point - reference;
  const Float distance_squared = length_squared(to_light);
  const Float distance = sqrt(distance_squared);
  LightSample s;
  s.wi = to_light * (1.0f / select(distance > 0.0f, distance, 1.0f));
  const Float cos_light = abs(dot(normal, s.wi));
  s.distance = shortened(distance, ray_end_error(reference, point, extent, distance), cos_light);
  s.radiance = lanes.radiance();
  s.cosine = cos_light;
  const Mask usable = lanes.shines_towards(normal, -s.wi) & (cos_light > 0.0f) & (distance > 0.0f);
  s.pdf = select_or_zero(usable, pdf_area * distance_squared / cos_light);
  s.valid = usable & (s.pdf > 0.0f) & is_finite(s.pdf);
  s.delta = Mask::none();
  return s;
}

/// Solid-angle density of a direction towards `point` that is sampled by area with density `pdf_area`.
TESSERA_INLINE Float pdf_from_point(const LightLanes& lanes, Vec3 reference, Vec3 wi, Vec3 point, Vec3 normal,
                                    Float pdf_area) {
  const Float cos_light = abs(dot(normal, wi));
  const Mask usable = lanes.shines_towards(normal, -wi) & (cos_light > 0.0f);
  return select_or_zero(usable, pdf_area * length_squared(point - reference) / cos_light);
}

}  // namespace tessera::render::TESSERA_ISA
