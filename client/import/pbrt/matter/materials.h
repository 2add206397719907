// pbrt materials, named and not, -> Material messages.
#pragma once

#include <map>
#include <string>
#include <unordered_map>
#include <vector>

#include "import/pbrt/matter/textures.h"

namespace tessera::client::pbrt {

/// Material that a shape is made of: a named material, one given in place (an index), or neither: pbrt's
/// default.
struct MaterialRef {
  int anonymous = -1;
  std::string name;
};

/// All materials of the file. A material is converted when something refers to it.
class MaterialTable {
 public:
  MaterialTable(Context& context, SceneTextures& textures) : context_(context), textures_(textures) {}

  /// MakeNamedMaterial; the type is among the parameters.
  void define_named(const std::string& name, ParameterList parameters);
  /// Material "type" ...; the index for MaterialRef.
  int define_anonymous(const std::string& type, ParameterList parameters);

  /// The name in the scene ("" for the default); reports an unknown name at `where`.
  std::string use(const MaterialRef& ref, SourceLocation where);
  /// Whether the material is no surface at all.
  bool is_interface(const MaterialRef& ref) const;

 private:
  enum class State { kDefined, kInProgress, kDone };
  struct Entry {
    std::string name;  // name in the scene
    std::string type;
    ParameterList parameters;
    State state = State::kDefined;
  };

  int add(std::string name, const std::string& type, ParameterList parameters);
  void convert(Entry& entry);

  Context& context_;
  SceneTextures& textures_;
  int nesting_ = 0;  // materials that are being converted, each for the mix before
  std::vector<Entry> entries_;
  std::map<std::string, int> named_;
  std::unordered_map<std::string, std::string> scene_name_of_content_;
};

}  // namespace tessera::client::pbrt
