// Evaluating textures, 16 points at a time.
#pragma once

#include "render/color/spectrum.h"
#include "render/color/texture_table.h"
#include "render/core/texture_point.h"
#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

/// Linear Rec.709 at a point for active lanes, else 0. `texture` is one node of the table for all lanes.
/// (0, 0) is the lower left corner of images. Those that are filtered are bilinear at full resolution where
/// `at` has no footprint.
Color eval_texture(const TextureTable& table, int texture, const TexturePoint& at, Mask active);

/// The mean of the components of eval_texture.
Float eval_texture_scalar(const TextureTable& table, int texture, const TexturePoint& at, Mask active);

}  // namespace tessera::render::TESSERA_ISA
