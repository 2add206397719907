#include "image/color_space.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "image/exr/channel_names.h"
#include "wire/colour_channels.h"

namespace tessera::client {
namespace {

Chromaticities chromaticities_of(const spectra::RgbSpace& space) {
  Chromaticities result;
  float* to = result.xy.data();
  for (const spectra::Chromaticity& one : {space.red, space.green, space.blue, space.white}) {
    *to++ = static_cast<float>(one.x);
    *to++ = static_cast<float>(one.y);
  }
  return result;
}

/// The distance by which files of other programs are off, because they round.
bool same(const spectra::RgbSpace& a, const spectra::RgbSpace& b) {
  constexpr float kRounding = 1e-4f;
  const Chromaticities first = chromaticities_of(a), second = chromaticities_of(b);
  return std::ranges::equal(first.xy, second.xy,
                            [](float x, float y) { return std::abs(x - y) <= kRounding; });
}

/// Whether every colour has red, green and blue of the space, and white has some light.
bool spans_colors(const spectra::RgbSpace& space) {
  const auto finite = [](const spectra::Matrix3& matrix) {
    return std::ranges::all_of(matrix, [](const spectra::Triple& row) {
      return std::ranges::all_of(row, [](double v) { return std::abs(v) < 1e6; });
    });
  };
  return finite(spectra::xyz_from_rgb(space)) && finite(spectra::rgb_from_xyz(space));
}

void convert(const spectra::Matrix3& matrix, std::vector<float>& r, std::vector<float>& g,
             std::vector<float>& b) {
  for (std::size_t i = 0; i < r.size(); ++i) {
    const spectra::Triple converted = spectra::times(matrix, {r[i], g[i], b[i]});
    r[i] = static_cast<float>(converted[0]), g[i] = static_cast<float>(converted[1]);
    b[i] = static_cast<float>(converted[2]);
  }
}

Channel* find(Image& image, const std::string& name) {
  const auto it = std::ranges::find(image.channels, name, &Channel::name);
  return it == image.channels.end() ? nullptr : &*it;
}

}  // namespace

spectra::RgbSpace space_of(const Image& image) {
  const auto found = image.metadata.find(kChromaticities);
  const auto* const told =
      found == image.metadata.end() ? nullptr : std::get_if<Chromaticities>(&found->second);
  if (told == nullptr) return spectra::kRec709;
  const auto at = [&](std::size_t i) { return spectra::Chromaticity{told->xy[i], told->xy[i + 1]}; };
  const spectra::RgbSpace space = {at(0), at(2), at(4), at(6)};
  return spans_colors(space) ? space : spectra::kRec709;
}

void set_space(const spectra::RgbSpace& space, Image& image) {
  if (same(space, spectra::kRec709)) {
    image.metadata.erase(kChromaticities);
  } else {
    image.metadata[kChromaticities] = chromaticities_of(space);
  }
}

std::optional<spectra::Matrix3> rec709_from(const Image& image) {
  const spectra::RgbSpace space = space_of(image);
  if (same(space, spectra::kRec709)) return std::nullopt;
  return spectra::rgb_from_rgb(spectra::kRec709, space);
}

void convert_space(const spectra::RgbSpace& space, Image& image) {
  const spectra::RgbSpace from = space_of(image);
  if (!same(space, from)) {
    const spectra::Matrix3 matrix = spectra::rgb_from_rgb(space, from);
    std::vector<std::string> layers = {""};
    for (const Channel& channel : image.channels) {
      const std::string layer(layer_of(channel.name));
      if (channel.name == layer + ".R" && layer != "variance" && !is_cryptomatte(channel.name))
        layers.push_back(layer);
    }
    for (const std::string& layer : layers) {
      const auto names = wire::colour_channels_of(layer);
      const std::size_t skipped = layer.empty() ? 1 : 0;  // the point
      Channel* const r = find(image, names[0].substr(skipped));
      Channel* const g = find(image, names[1].substr(skipped));
      Channel* const b = find(image, names[2].substr(skipped));
      if (r != nullptr && g != nullptr && b != nullptr) convert(matrix, r->values, g->values, b->values);
    }
  }
  set_space(space, image);
}

}  // namespace tessera::client
