// Names of channels as other programs expect them.
#pragma once

#include <string>
#include <string_view>

#include "image/exr.h"

namespace tessera::client {

/// The name in a file of these names for a channel of ours: "depth.Z" is "ViewLayer.Depth.Z" for Blender and
/// "Z" for Nuke. Layers of light keep their own: "caustics.R" is "ViewLayer.caustics.R" for Blender.
std::string channel_name(std::string_view own, ChannelNames names);

/// The layer that a channel's name tells: "a.b" of "a.b.R"; empty: none.
std::string_view layer_of(std::string_view channel);

/// Whether a channel holds identifiers and coverages of Cryptomatte, which any loss makes useless.
bool is_cryptomatte(std::string_view channel);

}  // namespace tessera::client
