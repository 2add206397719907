// glTF materials -> materials, media and emission.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <tuple>

#include "import/gltf/context.h"
#include "import/gltf/matter/textures.h"
#include "import/gltf/matter/unique_names.h"

namespace tessera::client::gltf {

/// The parts of a primitive that its material looks at.
struct Vertices {
  bool has_uvs = false;
  bool has_color = false;  // attribute kColorAttribute
  bool has_alpha = false;  // attribute kAlphaAttribute
};

inline constexpr const char* kColorAttribute = "COLOR_0";
inline constexpr const char* kAlphaAttribute = "COLOR_0_ALPHA";

/// The parts of a material that shapes take.
struct Matter {
  std::string material;
  std::string medium;  // inside; empty: none
  std::optional<v1::AreaLight> emission;
  bool passes = false;  // light goes straight through somewhere
};

class MaterialTable {
 public:
  MaterialTable(Context& context, SceneTextures& textures) : context_(context), textures_(textures) {}

  /// The set of texture coordinates that most of its textures ask for, first of all its base colour.
  int texture_set(std::optional<std::size_t> material) const;
  /// Without a number: glTF's default.
  const Matter& use(std::optional<std::size_t> material, const Vertices& vertices);

 private:
  struct Writer;
  using Key = std::tuple<std::optional<std::size_t>, bool, bool, bool>;

  Matter write(std::optional<std::size_t> material, const Vertices& vertices);

  Context& context_;
  SceneTextures& textures_;
  std::map<Key, Matter> known_;
  UniqueNames names_;
};

}  // namespace tessera::client::gltf
