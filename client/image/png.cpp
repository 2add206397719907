#include "image/png.h"

#include <png.h>

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "image/atomic_file.h"

namespace tessera::client {

unsigned char srgb_byte(float linear) {
  if (!(linear > 0)) return 0;  // NaN too
  if (linear >= 1) return 255;
  const float encoded = linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
  return static_cast<unsigned char>(std::lround(255 * encoded));
}

absl::Status write_png(const Image& image, const std::string& path) {
  if (image.channels.empty() || image.pixel_count() == 0) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": the image is empty"));
  }
  const RgbPlanes rgb = rgb_planes(image);
  std::vector<unsigned char> bytes(3 * image.pixel_count());
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    bytes[3 * i] = srgb_byte(rgb.r[i]);
    bytes[3 * i + 1] = srgb_byte(rgb.g[i]);
    bytes[3 * i + 2] = srgb_byte(rgb.b[i]);
  }

  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.data.width());
  png.height = static_cast<png_uint_32>(image.data.height());
  png.format = PNG_FORMAT_RGB;
  return replace_file(path, [&](const std::string& file) {
    if (png_image_write_to_file(&png, file.c_str(), 0, bytes.data(), 0, nullptr)) return absl::OkStatus();
    return absl::InternalError(absl::StrCat(path, ": cannot write: ", png.message));
  });
}

}  // namespace tessera::client
