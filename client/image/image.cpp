#include "image/image.h"

#include <algorithm>
#include <limits>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "wire/colour_channels.h"

namespace tessera::client {

const Channel* Image::find(std::string_view name) const {
  const auto it = std::ranges::find(channels, name, &Channel::name);
  return it == channels.end() ? nullptr : &*it;
}

Channel& Image::add(std::string name) {
  return channels.emplace_back(Channel{std::move(name), std::vector<float>(pixel_count())});
}

std::array<std::size_t, 3> rgb_channels(const Image& image) {
  const auto number_of = [&](const char* name) {
    return static_cast<std::size_t>(std::ranges::find_if(image.channels,
                                                         [&](const Channel& channel) {
                                                           return absl::EqualsIgnoreCase(channel.name, name);
                                                         }) -
                                    image.channels.begin());
  };
  const std::size_t none = image.channels.size();
  const auto [red, green, blue] = wire::kColourChannels;
  const std::array<std::size_t, 3> rgb{number_of(red), number_of(green), number_of(blue)};
  if (std::ranges::find(rgb, none) == rgb.end()) return rgb;
  const std::size_t luminance = number_of("Y"), grey = luminance == none ? 0 : luminance;
  return {grey, grey, grey};
}

RgbPlanes rgb_planes(const Image& image) {
  const auto [r, g, b] = rgb_channels(image);
  const auto plane = [&](std::size_t channel) { return image.channels[channel].values.data(); };
  return {plane(r), plane(g), plane(b)};
}

void set_render_info(const RenderInfo& info, Image& image) {
  constexpr std::uint32_t kMax = std::numeric_limits<std::int32_t>::max();
  image.metadata["tessera.scene_digest"] = info.scene_digest;
  image.metadata["tessera.spp"] = static_cast<std::int32_t>(std::min(info.spp, kMax));
  image.metadata["tessera.seed"] = absl::StrCat(info.seed);
  image.metadata["tessera.integrator"] = info.integrator;
  image.metadata["tessera.integrator_kind"] = info.integrator_kind;
  if (!info.choice.empty()) image.metadata["tessera.auto"] = info.choice;
  image.metadata["tessera.sampler"] = info.sampler;
  image.metadata["tessera.isa"] = info.isa;
  image.metadata["tessera.arithmetic"] = absl::StrJoin(info.arithmetic, ", ");
  image.metadata["tessera.version"] = info.version;
  image.metadata["tessera.render_seconds"] = static_cast<float>(info.render_seconds);
}

}  // namespace tessera::client
