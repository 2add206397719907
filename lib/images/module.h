// Interface of the module with OpenImageIO: one function for each need, without exceptions and Abseil.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "images/image_blob.h"

namespace tessera::images {

enum class ImageFault : std::int32_t { kNone, kInvalid, kTooLarge };

inline std::string too_many_pixels(ImageSize size, std::uint64_t most) {
  return std::to_string(size.width) + " x " + std::to_string(size.height) +
         " texels are more than the limit of " + std::to_string(most);
}

struct ImageModule {
  /// `format`: OpenImageIO's name of it. With a fault `message` says what is wrong, without the file's name.
  ImageFault (*decode)(std::string_view blob, const char* format, std::uint64_t max_pixels,
                       ImagePixels& pixels, std::string& message);
  ImageFault (*size)(std::string_view blob, const char* format, ImageSize& size, std::string& message);
};

/// The one symbol that the module exports.
inline constexpr const char* kImageModuleFile = "libtessera_images.so";
inline constexpr const char* kImageModuleEntry = "tessera_images";
using ImageModuleEntry = const ImageModule* (*)();

}  // namespace tessera::images
