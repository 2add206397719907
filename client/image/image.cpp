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

RgbPlanes rgb_planes(const Image& image) {
  const auto plane = [&](const char* name) -> const float* {
    for (const Channel& channel : image.channels) {
      if (absl::EqualsIgnoreCase(channel.name, name)) return channel.values.data();
    }
    return nullptr;
  };
  const auto [red, green, blue] = wire::kColourChannels;
  const RgbPlanes rgb{plane(red), plane(green), plane(blue)};
  if (rgb.r && rgb.g && rgb.b) return rgb;
  const float* grey = plane("Y");
  if (!grey) grey = image.channels.front().values.data();
  return {grey, grey, grey};
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
