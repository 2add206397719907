// Readers of the plain forms of the commonest image files, for what OpenImageIO costs to load
// (docs/decisions/0014-scene-loading.md). Each gives exactly what OpenImageIO gives, or declines.
#pragma once

#include <cstdint>
#include <string_view>

#include "images/image_blob.h"

namespace tessera::images {

/// False for a file in another form, a damaged one, and one of more than `max_pixels`: `pixels` is then
/// unspecified, and OpenImageIO reads the file or says what is wrong with it. Of a file whose header is
/// plain, the size is there even so.
using ImageReader = bool (*)(std::string_view blob, std::uint64_t max_pixels, ImagePixels& pixels);

/// 8 bits a channel or fewer: grey, colour and palettes, with alpha or without.
bool read_png(std::string_view blob, std::uint64_t max_pixels, ImagePixels& pixels);
/// Grey, and what libjpeg makes RGB of.
bool read_jpeg(std::string_view blob, std::uint64_t max_pixels, ImagePixels& pixels);
/// 8 bits of grey or 24 of colour, plain or run-length encoded.
bool read_tga(std::string_view blob, std::uint64_t max_pixels, ImagePixels& pixels);
/// Grey and colour, little-endian, with a scale of 1.
bool read_pfm(std::string_view blob, std::uint64_t max_pixels, ImagePixels& pixels);
/// One part, not deep, of halves or floats, with the channels R, G, B, A, or R, G, B, or Y.
bool read_exr(std::string_view blob, std::uint64_t max_pixels, ImagePixels& pixels);

/// Whether the attributes of an EXR file's headers fit into it, and the blocks of pixels that they tell of
/// into some memory. OpenEXR makes room for whatever an attribute says that it takes, before it looks.
bool is_plausible_exr(std::string_view blob);

/// Gives `pixels` a size, and room for bytes (or for floats). False, and nothing is allocated, when the size
/// is not positive (then `pixels` stays without one) or beyond `max_pixels`, or when memory is short.
bool allot(std::int64_t width, std::int64_t height, bool floats, std::uint64_t max_pixels,
           ImagePixels& pixels);

}  // namespace tessera::images
