// Pyramids of averages, over which textures are filtered.
#pragma once

#include <cstdint>
#include <string_view>

#include "absl/status/status.h"
#include "render/color/texture_table.h"

namespace tessera::render {

/// Replaces the texels of an image by its pyramid, of linear values: 10.7 bytes a texel for images of 8 bits
/// (from 4), 21.3 for others (from 16). Sides are halved, rounded down; what is odd is cut into even parts
/// [Guthe & Heckbert 2005], so that every level has the mean of the image, whatever its wrap mode.
/// Errors as of check_pyramid().
absl::Status make_pyramid(TextureImage& image, std::string_view name);
/// InvalidArgument, with `name`, where the pyramid of an image of this size would have 2^29 texels or more.
absl::Status check_pyramid(std::int32_t width, std::int32_t height, std::string_view name);

}  // namespace tessera::render
