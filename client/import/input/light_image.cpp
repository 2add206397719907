#include "import/input/light_image.h"

#include <cmath>

#include "import/input/concat.h"
#include "import/input/input_file.h"

namespace tessera::client {
namespace {

const float* pixel(const LightImage& image, int x, int y) {
  return &image.rgb[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                         static_cast<std::size_t>(x))];
}

float linear_from_srgb(float v) { return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f); }

}  // namespace

double LightImage::luminance(int x, int y) const {
  const float* p = pixel(*this, x, y);
  return 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2];
}

double LightImage::mean_of_channels(int x, int y) const {
  const float* p = pixel(*this, x, y);
  return (double{p[0]} + p[1] + p[2]) / 3;
}

absl::StatusOr<LightImage> read_light_image(const std::filesystem::path& path) {
  const absl::StatusOr<InputFile> file = InputFile::open(path);
  if (!file.ok()) return file.status();
  const absl::StatusOr<images::ImagePixels> pixels = images::decode_image(file->bytes(), path.string());
  if (!pixels.ok()) return pixels.status();
  const bool encoded = pixels->floats.empty();
  const std::size_t count = encoded ? pixels->bytes.size() : pixels->floats.size() / 4;
  LightImage image{pixels->size.width, pixels->size.height, std::vector<float>(3 * count)};
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      const float value = encoded
                              ? linear_from_srgb(static_cast<float>(pixels->bytes[i] >> (8 * c) & 255) / 255)
                              : pixels->floats[4 * i + c];
      if (!std::isfinite(value)) {
        return absl::InvalidArgumentError(
            concat(path.string(), ": a pixel of an image on a light is not finite"));
      }
      image.rgb[3 * i + c] = value;
    }
  }
  return image;
}

absl::StatusOr<images::ImageSize> read_image_size(const std::filesystem::path& path) {
  const absl::StatusOr<InputFile> file = InputFile::open(path);
  if (!file.ok()) return file.status();
  return images::image_size(file->bytes(), path.string());
}

}  // namespace tessera::client
