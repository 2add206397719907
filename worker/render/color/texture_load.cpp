#include "render/color/texture_load.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace tessera::render {
namespace {

double linear_from_srgb(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }

void fill_decode_table(TextureImage& image, TexelEncoding encoding, float gamma) {
  for (int i = 0; i < 256; ++i) {
    const double v = i / 255.0;
    const double linear = encoding == TexelEncoding::kLinear  ? v
                          : encoding == TexelEncoding::kGamma ? std::pow(v, gamma)
                                                              : linear_from_srgb(v);
    image.decode[i] = static_cast<float>(linear);
  }
}

/// Same bound as for the numbers of a scene (wire/scene_numbers.h).
constexpr double kLargestTexel = 1e18;

/// Decodes in place: R, G and B by the encoding, and nothing stays that is not finite.
void decode_floats(std::vector<float>& texels, TexelEncoding encoding, float gamma) {
  const auto linear = [&](float v) {
    if (encoding == TexelEncoding::kSrgb) return linear_from_srgb(v);
    if (encoding == TexelEncoding::kGamma) return std::pow(std::max(double{v}, 0.0), double{gamma});
    return double{v};
  };
  for (std::size_t i = 0; i < texels.size(); ++i) {
    float& v = texels[i];
    const double decoded = i % 4 == 3 ? double{v} : std::clamp(linear(v), -kLargestTexel, kLargestTexel);
    v = std::isfinite(v) ? static_cast<float>(decoded) : 0.0f;
  }
}

}  // namespace

absl::StatusOr<images::ImageSize> check_texture_image(std::string_view bytes, std::string_view name,
                                                      const TextureLoadOptions& options) {
  return images::image_size(bytes, std::string(name), options.max_texels);
}

absl::StatusOr<TextureImage> load_texture_image(std::string_view bytes, std::string_view name,
                                                const TextureLoadOptions& options) {
  absl::StatusOr<images::ImagePixels> pixels =
      images::decode_image(bytes, std::string(name), options.max_texels);
  if (!pixels.ok()) return pixels.status();
  TextureImage image;
  image.width = pixels->size.width;
  image.height = pixels->size.height;
  TexelEncoding encoding = options.encoding;
  if (pixels->floats.empty()) {
    if (encoding == TexelEncoding::kAuto) encoding = TexelEncoding::kSrgb;
    image.format = encoding == TexelEncoding::kLinear ? TexelFormat::kLinear8 : TexelFormat::kSrgb8;
    fill_decode_table(image, encoding, options.gamma);
    image.texels8.assign(pixels->bytes.begin(), pixels->bytes.end());
  } else {
    if (pixels->floating_point) encoding = TexelEncoding::kLinear;
    image.format = TexelFormat::kFloat;
    decode_floats(pixels->floats, encoding, options.gamma);
    image.texels32.assign(pixels->floats.begin(), pixels->floats.end());
  }
  return image;
}

}  // namespace tessera::render
