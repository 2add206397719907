// Surfaces that let rays pass with probability 1 - alpha.
#pragma once

#include "render/core/vec.h"

namespace tessera::render {
struct ShapeTable;
struct TextureTable;
}  // namespace tessera::render

namespace tessera::render::TESSERA_ISA {

/// Rays, in the space of the shape's vertices, that pass through it where they meet it. The choice is a hash
/// of the ray, so it is the same on every machine.
Mask let_pass(const ShapeTable& shapes, const TextureTable& textures, std::int32_t shape, Int primitive,
              Float u, Float v, Vec3 o, Vec3 d, Mask active);

}  // namespace tessera::render::TESSERA_ISA
