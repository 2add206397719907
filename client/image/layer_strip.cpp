#include "image/layer_strip.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "image/heat_map.h"
#include "wire/colour_channels.h"

namespace tessera::client {

absl::StatusOr<Image> layer_strip(const Image& image, const std::vector<std::string>& layers) {
  const std::int32_t width = image.data.width(), height = image.data.height(),
                     count = static_cast<std::int32_t>(layers.size());
  Image strip, visits;
  if (std::ranges::find(layers, "visits") != layers.end()) {
    absl::StatusOr<Image> map = heat_map(image);
    if (!map.ok()) return map.status();
    visits = *std::move(map);
  }
  strip.data = strip.display = {0, 0, width * count, height};
  strip.metadata = image.metadata;
  for (const char* const band : wire::kColourChannels) {
    Channel& whole = strip.add(band);
    for (std::int32_t i = 0; i < count; ++i) {
      const std::string& layer = layers[static_cast<std::size_t>(i)];
      const Image& from = layer == "visits" ? visits : image;
      const Channel* const part = from.find(layer == "rgba" ? band : absl::StrCat(layer, ".", band));
      if (part == nullptr)
        return absl::InvalidArgumentError(absl::StrCat("the image has no layer '", layer, "'"));
      for (std::int32_t y = 0; y < height; ++y)
        std::copy_n(part->values.data() + y * width, width, whole.values.data() + (y * count + i) * width);
    }
  }
  return strip;
}

}  // namespace tessera::client
