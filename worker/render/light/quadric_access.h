// Reading the quadrics behind sphere and disk lights.
#pragma once

#include "render/core/affine.h"
#include "render/light/light_access.h"

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

}  // namespace tessera::render::TESSERA_ISA
