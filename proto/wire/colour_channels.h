// Names of the channels in which a sensor tells colours, wherever results and images have them.
#pragma once

#include <array>
#include <string>
#include <string_view>

namespace tessera::wire {

/// The picture's, in order; the first channels of every result.
inline constexpr std::array<const char*, 3> kColourChannels{"R", "G", "B"};

/// Channels of a layer, in the same order: "albedo.R" and so on.
inline std::array<std::string, kColourChannels.size()> colour_channels_of(std::string_view layer) {
  std::array<std::string, kColourChannels.size()> names;
  for (std::size_t c = 0; c < names.size(); ++c) names[c] = std::string(layer) + "." + kColourChannels[c];
  return names;
}

}  // namespace tessera::wire
