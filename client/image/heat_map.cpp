#include "image/heat_map.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace tessera::client {

std::array<float, 3> heat_colour(double count) {
  constexpr std::size_t kParts = 4;
  constexpr std::array<std::array<double, 3>, kParts + 1> kStops = {
      {{0, 0, 0}, {0.05, 0.05, 0.5}, {0.7, 0.02, 0.05}, {0.95, 0.6, 0}, {1, 1, 1}}};
  const double most = 10;  // log2 of 1024
  const double x = std::clamp(std::log2(std::max(count, 1.0)) / most, 0.0, 1.0) * kParts;
  const std::size_t stop = std::min(kParts - 1, static_cast<std::size_t>(x));
  std::array<float, 3> colour;
  for (std::size_t c = 0; c < 3; ++c) {
    colour[c] =
        static_cast<float>(std::lerp(kStops[stop][c], kStops[stop + 1][c], x - static_cast<double>(stop)));
  }
  return colour;
}

absl::StatusOr<Image> heat_map(const Image& image) {
  const Channel* const nodes = image.find("visits.nodes");
  const Channel* const primitives = image.find("visits.primitives");
  if (nodes == nullptr || primitives == nullptr)
    return absl::InvalidArgumentError("the image has no channels of --aov visits");
  Image map;
  map.data = image.data, map.display = image.display;
  for (const char* name : {"visits.R", "visits.G", "visits.B"}) map.add(name);
  for (std::size_t i = 0; i < nodes->values.size(); ++i) {
    const std::array<float, 3> colour = heat_colour(double{nodes->values[i]} + primitives->values[i]);
    for (std::size_t c = 0; c < 3; ++c) map.channels[c].values[i] = colour[c];
  }
  return map;
}

}  // namespace tessera::client
