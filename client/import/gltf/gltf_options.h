// Choices from a glTF file, which may hold several cameras, scenes, moments and looks.
#pragma once

#include <optional>
#include <string>

namespace tessera::client {

struct GltfOptions {
  std::string camera;          // name or number; empty: the first of the scene
  std::optional<double> time;  // seconds, at which animations are looked at; none: as nodes stand
  std::string animation;       // name or number; empty: all
  std::string variant;         // name in KHR_materials_variants; empty: the materials of the primitives
  std::optional<double> default_light;  // radiance of a white sky, where the file has no light
};

}  // namespace tessera::client
