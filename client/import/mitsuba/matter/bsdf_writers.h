// One function for each BSDF that scatters by itself.
#pragma once

#include <string>
#include <string_view>

#include "import/mitsuba/matter/textures.h"

namespace tessera::client::mitsuba {

struct BsdfType {
  std::string_view name;
  void (*write)(PropertyReader& reader, SceneTextures& textures, v1::Material& material);
  bool transmits = false;  // both sides have the same right to light
};

/// Null for a type that there is no writer for.
const BsdfType* find_bsdf_type(std::string_view name);

/// For messages: "diffuse, conductor, ...".
std::string names_of_bsdf_types();

}  // namespace tessera::client::mitsuba
