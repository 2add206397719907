// Pyramids of averages, over which textures are filtered.
#pragma once

#include <string_view>

#include "absl/status/status.h"
#include "render/color/texture_table.h"

namespace tessera::render {

/// Replaces the texels of an image by its pyramid, of linear values: 10.7 bytes a texel for images of 8 bits
/// (from 4), 21.3 for others (from 16). Sides are halved, rounded down; what is odd is cut into even parts
/// [Guthe & Heckbert 2005], so that every level has the mean of the image, whatever its wrap mode.
/// InvalidArgument, with `name`, where it would have 2^29 texels or more.
absl::Status make_pyramid(TextureImage& image, std::string_view name);

}  // namespace tessera::render
