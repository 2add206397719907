#include "render/scene/view/aperture.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "absl/strings/str_cat.h"
#include "render/color/texture_load.h"
#include "render/scene/values/located.h"

namespace tessera::render {

namespace {

constexpr std::int32_t kMostPixels = 4096;  // of a row or column

/// The mean of red, green and blue; what is below 0 lets nothing through.
float brightness_at(const TextureImage& image, std::size_t texel) {
  float sum = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    sum += image.format == TexelFormat::kFloat ? image.texels32[4 * texel + c]
                                               : image.decode[(image.texels8[texel] >> (8 * c)) & 0xff];
  }
  return std::max(sum / 3, 0.0f);
}

}  // namespace

absl::StatusOr<AperturePicture> aperture_picture(const v1::BlobRef& image, const BlobSource& blobs) {
  const auto fault = [&](const std::string& what) {
    return absl::InvalidArgumentError(absl::StrCat("aperture '", image.path(), "' ", what));
  };
  const auto bytes = blobs(image.digest());
  if (!bytes.ok()) return located(bytes.status(), absl::StrCat("aperture '", image.path(), "'"));
  const auto size = check_texture_image(bytes->bytes, image.path());
  if (!size.ok()) return size.status();
  if (std::max(size->width, size->height) > kMostPixels)
    return fault(absl::StrCat("has ", size->width, " x ", size->height, " pixels; ", kMostPixels,
                              " are the most in a row or column"));
  const auto loaded = load_texture_image(bytes->bytes, image.path());
  if (!loaded.ok()) return loaded.status();
  const auto width = static_cast<std::size_t>(loaded->width),
             height = static_cast<std::size_t>(loaded->height);
  std::vector<float> open(width * height);
  double sum = 0;
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x)
      sum += open[(height - 1 - y) * width + x] = brightness_at(*loaded, y * width + x);
  }
  if (!(sum > 0)) return fault("is black: it lets no light through");
  AperturePicture picture;
  picture.density = Piecewise2d::build(open, loaded->width, loaded->height);
  picture.transmission = static_cast<float>(sum / static_cast<double>(open.size()));
  return picture;
}

}  // namespace tessera::render
