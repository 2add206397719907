// Surfaces with holes: which rays go on where opacity is below 1.
#pragma once

#include <cstdint>

#include "render/color/texture_table.h"
#include "render/shape/analytic_shape.h"

namespace tessera::render::TESSERA_ISA {

/// The active lanes whose rays pass the hole at their hit, with probability 1 - alpha. The choice is a hash
/// of the ray, so it is the same on every machine. `crossing` counts the hits of one ray on one primitive,
/// from 0 on.
Mask passes_alpha(const ShapeTable& shapes, const TextureTable& textures, std::int32_t shape, const Hit& hit,
                  Vec3 o, Vec3 d, std::uint32_t crossing, Mask active);

/// AnalyticShape::nearest() of a shape with holes: rays that pass one go on to their next hit.
Float nearest_behind_holes(const ShapeTable& shapes, const TextureTable& textures, std::int32_t shape,
                           std::int32_t primitive, ShapeRays rays);

}  // namespace tessera::render::TESSERA_ISA
