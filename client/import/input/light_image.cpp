#include "import/input/light_image.h"

#include <OpenImageIO/imageio.h>

#include <cmath>
#include <exception>
#include <memory>

#include "import/input/concat.h"

namespace tessera::client {
namespace {

constexpr int kMaxSide = 32768;

const float* pixel(const LightImage& image, int x, int y) {
  return &image.rgb[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                         static_cast<std::size_t>(x))];
}

float linear_from_srgb(float v) { return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f); }

absl::StatusOr<LightImage> read(const std::filesystem::path& path) {
  const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(path.string());
  if (input == nullptr) return absl::InvalidArgumentError(concat(path.string(), ": ", OIIO::geterror()));
  const OIIO::ImageSpec spec = input->spec();
  if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1 || spec.width > kMaxSide || spec.height > kMaxSide) {
    return absl::InvalidArgumentError(concat(path.string(), ": an image of ", spec.width, " x ", spec.height,
                                             " pixels and ", spec.nchannels, " channels cannot be used"));
  }
  const int channels = spec.nchannels >= 3 ? 3 : 1;
  const std::size_t pixels = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
  std::vector<float> values(pixels * static_cast<std::size_t>(channels));
  if (!input->read_image(0, 0, 0, channels, OIIO::TypeDesc::FLOAT, values.data())) {
    return absl::InvalidArgumentError(concat(path.string(), ": ", input->geterror()));
  }
  const bool encoded = spec.format.size() == 1;
  LightImage image{spec.width, spec.height, std::vector<float>(3 * pixels)};
  for (std::size_t i = 0; i < image.rgb.size(); ++i) {
    const float value = values[channels == 3 ? i : i / 3];
    if (!std::isfinite(value)) {
      return absl::InvalidArgumentError(concat(path.string(), ": a pixel of an image on a light is not finite"));
    }
    image.rgb[i] = encoded ? linear_from_srgb(value) : value;
  }
  return image;
}

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
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    return absl::NotFoundError(concat(path.string(), ": no such file"));
  try {
    return read(path);
  } catch (const std::exception& problem) {
    return absl::InvalidArgumentError(concat(path.string(), ": ", problem.what()));
  }
}

}  // namespace tessera::client
