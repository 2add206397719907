#include "plot/picture_map.h"

#include <array>
#include <variant>

#include "image/color_space.h"
#include "spectra/color/rgb_space.h"

namespace tessera::client {

double white_luminance(const Image& image, const std::optional<double>& asked) {
  if (asked) return *asked;
  const auto found = image.metadata.find("whiteLuminance");
  if (found == image.metadata.end()) return kLumensPerWatt;
  const float* const said = std::get_if<float>(&found->second);
  return said != nullptr && *said > 0 ? *said : kLumensPerWatt;
}

absl::StatusOr<ValueGrid> luminance_grid(const Image& image, double white_luminance) {
  if (image.channels.empty() || image.pixel_count() == 0)
    return absl::InvalidArgumentError("the image is empty");
  if (image.metadata.contains(kRawChannels)) {
    return absl::FailedPreconditionError(
        "red, green and blue are a sensor's own, which tell no luminance; --sensor cie1931 does where the "
        "image "
        "has bands");
  }
  const RgbPlanes planes = rgb_planes(image);
  const spectra::Triple weights = spectra::xyz_from_rgb(space_of(image))[1];
  ValueGrid grid{
      static_cast<std::size_t>(image.data.width()), static_cast<std::size_t>(image.data.height()), {}};
  grid.values.reserve(image.pixel_count());
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    const double light = weights[0] * planes.r[i] + weights[1] * planes.g[i] + weights[2] * planes.b[i];
    grid.values.push_back(white_luminance * light);
  }
  return grid;
}

FalseColorOptions picture_look() {
  FalseColorOptions look;
  look.unit = "cd/m\u00b2";
  look.cut = 0.001;
  look.shortest_isoline = 24;
  return look;
}

}  // namespace tessera::client
