// One function for each pbrt texture type.
#pragma once

#include <string>
#include <string_view>

#include "import/pbrt/textures.h"

namespace tessera::client::pbrt {

using TextureWriter = void (*)(TextureKind kind, ValueReader& values, v1::Texture& texture);

/// Null for a type that pbrt-v4 does not have.
TextureWriter find_texture_writer(std::string_view type);

/// For messages: "imagemap, constant, ...".
std::string names_of_texture_types();

}  // namespace tessera::client::pbrt
