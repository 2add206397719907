// Functions that lights on quadrics share: reading them, densities, bounds.
#pragma once

#include "render/core/affine.h"
#include "render/light/area/area_light.h"

namespace tessera::render::TESSERA_ISA {

/// The quadrics of 16 lights.
class QuadricLanes {
 public:
  TESSERA_INLINE explicit QuadricLanes(const LightLanes& lanes)
      : table_(*lanes.table.shapes), active_(lanes.active) {
    const Int shape = lanes.field(&LightRecord::shape);
    quadric_ = gather_member(table_.shapes.data(), &ShapeRecord::quadric, shape, active_);
    flip_ = (gather_member(table_.shapes.data(), &ShapeRecord::flags, shape, active_) & kFlipNormal) != 0;
  }

  TESSERA_INLINE Float field(float QuadricRecord::*member) const {
    return gather_member(table_.quadrics.data(), member, quadric_, active_);
  }
  TESSERA_INLINE WideAffine affine(Affine QuadricRecord::*member) const {
    const float* base = (table_.quadrics.data()->*member).m;
    const Int offset = quadric_ * static_cast<std::int32_t>(sizeof(QuadricRecord) / 4);
    WideAffine result;
    for (int i = 0; i < 12; ++i) result.m[i] = gather(base + i, offset, active_);
    return result;
  }
  TESSERA_INLINE Mask flipped() const { return flip_; }
  /// `normal` turned to the side that the shape counts as its front.
  TESSERA_INLINE Vec3 front(Vec3 normal) const { return select(flip_, -normal, normal); }

 private:
  const ShapeTable& table_;
  Mask active_, flip_;
  Int quadric_;
};

/// Density by area of a point that is chosen uniformly by area in object space, `object_area` being all of
/// it. `n` is the unit normal there, in object space; areas scale by |det M| |M^-T n|.
TESSERA_INLINE Float stretched_density(Float object_area, const WideAffine& to, const WideAffine& from,
                                       Vec3 n) {
  const auto& m = to.m;
  const Float determinant = dot(Vec3{m[0], m[1], m[2]}, cross({m[4], m[5], m[6]}, {m[8], m[9], m[10]}));
  return 1.0f / (object_area * abs(determinant) * length(transform_normal(from, n)));
}

/// Area of the zone of a sphere, or of the wall of a cylinder [Archimedes: they are the same].
TESSERA_INLINE Float zone_area(const QuadricLanes& quadric) {
  return quadric.field(&QuadricRecord::radius) * quadric.field(&QuadricRecord::phi_max) *
         (quadric.field(&QuadricRecord::z_max) - quadric.field(&QuadricRecord::z_min));
}

inline const QuadricRecord& quadric_of(const ShapeTable& shapes, const ShapeRecord& shape) {
  return shapes.quadrics[static_cast<std::size_t>(shape.quadric)];
}
inline const QuadricRecord& quadric_of(const LightTable& table, const LightRecord& light) {
  return quadric_of(*table.shapes, table.shapes->shapes[static_cast<std::size_t>(light.shape)]);
}

inline vec64::Vec column(const Affine& a, int c) { return {a.m[c], a.m[4 + c], a.m[8 + c]}; }

/// A box about a quadric within these heights, by the corners of one about it in its own space.
inline void bound_quadric(const QuadricRecord& q, double z_min, double z_max, LightBounds& b) {
  const double z[] = {z_min, z_max};
  const auto& m = q.render_from_object.m;
  for (int i = 0; i < 8; ++i) {
    const vec64::Vec p = {i & 1 ? q.radius : -q.radius, i & 2 ? q.radius : -q.radius, z[i >> 2]};
    vec64::Vec at;
    for (std::size_t r = 0; r < 3; ++r)
      at[r] = m[4 * r] * p[0] + m[4 * r + 1] * p[1] + m[4 * r + 2] * p[2] + m[4 * r + 3];
    b.add(at);
  }
}

}  // namespace tessera::render::TESSERA_ISA
