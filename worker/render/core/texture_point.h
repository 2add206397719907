// The point of a surface as textures see it.
#pragma once

#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

/// Where textures are looked up: all that any kind of texture depends on.
struct TexturePoint {
  Vec2 uv;
  Vec3 p;  // render space
  Vec3 n;  // shading normal, render space, unit
  // For attributes of meshes
  Int shape, primitive;
  Vec2 barycentric;  // weights of corners 1 and 2
  // The area of a look-up, for textures that are filtered: from the point to the ends of the two half-axes of
  // a footprint, in render space and in uv. Set with has_footprint alone.
  bool has_footprint = false;
  Vec3 dpdx, dpdy;
  Vec2 duvdx, duvdy;

  /// Point for textures that need no more than uv: images on lights, for example.
  static TESSERA_INLINE TexturePoint at(Vec2 uv) {
    const Vec3 zero{Float(0.0f), Float(0.0f), Float(0.0f)};
    TexturePoint point;
    point.uv = uv, point.p = zero, point.n = zero;
    point.shape = Int(-1), point.primitive = Int(0), point.barycentric = {Float(0.0f), Float(0.0f)};
    return point;
  }
};

}  // namespace tessera::render::TESSERA_ISA
