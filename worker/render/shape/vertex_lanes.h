// Vertices of meshes as 16 lanes read them, of meshes that deform at the lanes' times.
#pragma once

#include "render/core/vec.h"
#include "render/shape/shape_table.h"

namespace tessera::render::TESSERA_ISA {

/// One vertex a lane, read in two halves of four floats.
class VertexLanes {
 public:
  TESSERA_INLINE VertexLanes(const ShapeTable& table, Int index, Mask active)
      : base_(table.vertices.data()->position),
        at_(index * static_cast<std::int32_t>(sizeof(Vertex) / 4)),
        active_(active) {
    position_u_ = gather4(base_, at_, active);
  }
  TESSERA_INLINE Vec3 position() const { return {position_u_.c[0], position_u_.c[1], position_u_.c[2]}; }
  /// Wanted only where there are normals or uvs.
  TESSERA_INLINE void read_rest() { normal_v_ = gather4(base_ + 4, at_, active_); }
  TESSERA_INLINE Vec3 normal() const { return {normal_v_.c[0], normal_v_.c[1], normal_v_.c[2]}; }
  TESSERA_INLINE Vec2 uv() const { return {position_u_.c[3], normal_v_.c[3]}; }

  /// Moves the place, in these lanes, `part` of the way to that of the same vertex at the next key. Returns
  /// how large the coordinates are that it is computed from.
  TESSERA_INLINE Float mix_position(const VertexLanes& next, Float part, Mask lanes) {
    const Float rest = 1.0f - part;
    Float size(0.0f);
    for (int k = 0; k < 3; ++k) {
      const Float a = position_u_.c[k], b = next.position_u_.c[k];
      position_u_.c[k] = select(lanes, fma(rest, a, part * b), a);
      size = max(size, fma(rest, abs(a), part * abs(b)));
    }
    return select_or_zero(lanes, size);
  }
  /// The same of the normal, once both are read.
  TESSERA_INLINE void mix_normal(const VertexLanes& next, Float part, Mask lanes) {
    for (int k = 0; k < 3; ++k) {
      const Float a = normal_v_.c[k];
      normal_v_.c[k] = select(lanes, fma(1.0f - part, a, part * next.normal_v_.c[k]), a);
    }
  }

 private:
  const float* base_;
  Int at_;
  Mask active_;
  Float4 position_u_, normal_v_;
};

/// The lanes' times between two keys (KeyTime); 0 of all in those that do not deform.
struct KeyLanes {
  Int before;
  Float part;
  Int vertices;  // of a key

  TESSERA_INLINE KeyLanes(const ShapeTable& table, Int shape, Float time, Mask deforming) {
    const auto field = [&](std::int32_t ShapeRecord::*member) {
      return gather_member(table.shapes.data(), member, shape, deforming);
    };
    const Int segments = select_or_zero(deforming, field(&ShapeRecord::key_segments));
    const Float place = select_or_zero(deforming, time) * to_float(segments);
    before = max(min(to_int(place), segments - 1), 0);
    part = place - to_float(before);
    vertices = select_or_zero(deforming, field(&ShapeRecord::vertex_count));
  }
};

}  // namespace tessera::render::TESSERA_ISA
