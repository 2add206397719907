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

  /// Point for textures that need no more than uv: images on lights, for example.
  static TESSERA_INLINE TexturePoint at(Vec2 uv) {
    const Vec3 zero{Float(0.0f), Float(0.0f), Float(0.0f)};
    return {uv, zero, zero, Int(-1), Int(0), {Float(0.0f), Float(0.0f)}};
  }
};

}  // namespace tessera::render::TESSERA_ISA
