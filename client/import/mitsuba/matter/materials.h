// Mitsuba BSDFs -> Material messages. Wrappers (mask, twosided, ...) become fields of what they wrap.
#pragma once

#include <map>
#include <set>
#include <string>
#include <tuple>

#include "import/mitsuba/matter/bsdf_writers.h"

namespace tessera::client::mitsuba {

class MaterialTable {
 public:
  MaterialTable(Context& context, SceneTextures& textures) : context_(context), textures_(textures) {}

  /// The name in the scene of a BSDF.
  std::string use(Object& bsdf) { return use(bsdf, Wrapping{}); }
  /// Material of a shape without one: diffuse, black where the shape emits light.
  std::string use_default(bool emits);

 private:
  /// Wrappers that surround a BSDF.
  struct Wrapping {
    bool two_sided = false;
    v1::Material fields;  // back, opacity, displacement, normal_map
  };
  using Key = std::tuple<const Object*, bool, std::string>;

  std::string use(Object& bsdf, const Wrapping& wrapping);
  std::string write(Object& bsdf, const Wrapping& wrapping);
  std::string write_leaf(PropertyReader& reader, const Wrapping& wrapping);
  std::string write_two_sided(PropertyReader& reader, Wrapping wrapping);
  std::string write_mask(PropertyReader& reader, Wrapping wrapping);
  static void read_map_options(PropertyReader& reader);
  std::string write_bump_map(PropertyReader& reader, Wrapping wrapping);
  std::string write_normal_map(PropertyReader& reader, Wrapping wrapping);
  std::string write_blend(PropertyReader& reader, const Wrapping& wrapping);
  std::string use_only_child(PropertyReader& reader, const Wrapping& wrapping);

  Context& context_;
  SceneTextures& textures_;
  std::map<Key, std::string> names_;
  bool too_many_names_ = false;  // true once it was reported
  std::set<std::string> taken_;
};

}  // namespace tessera::client::mitsuba
