// One function for each pbrt texture type.
#pragma once

#include <string>
#include <string_view>

#include "import/pbrt/matter/textures.h"

namespace tessera::client::pbrt {

/// A Texture directive: which name space it is in, and the transformation at it.
struct TextureInput {
  TextureKind kind;
  const Imath::M44d& world_from_texture;
  ValueReader& values;
};

using TextureWriter = void (*)(const TextureInput& in, v1::Texture& texture);

/// Null for a type that pbrt-v4 does not have.
TextureWriter find_texture_writer(std::string_view type);

/// For messages: "imagemap, constant, ...".
std::string names_of_texture_types();

}  // namespace tessera::client::pbrt
