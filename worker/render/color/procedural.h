// Textures without an image: noise, marble, dots.
#pragma once

#include "render/color/spectrum.h"
#include "render/color/texture_table.h"
#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

/// Value of a kNoise node at a point of its own space.
Color noise_texture(const TextureNode& node, Vec3 p);

/// Whether (s, t) lies inside one of pbrt-v4's polka dots.
Mask inside_dot(Vec2 st);

}  // namespace tessera::render::TESSERA_ISA
