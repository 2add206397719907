#include <algorithm>
#include <map>

#include "import/gltf/file/schema.h"
#include "import/gltf/matter/textures.h"
#include "import/gltf/rules/rules.h"

namespace tessera::client::gltf {
namespace mesh_rules {

/// Formats of an attribute; `quantized` ones with KHR_mesh_quantization alone.
struct Semantic {
  std::string_view name;  // a number follows where '_' is at its end
  std::string_view formats, quantized;
};

constexpr Semantic kAttributes[] = {
    {"POSITION", "VEC3 f32", "VEC3 i8,VEC3 i8n,VEC3 u8,VEC3 u8n,VEC3 i16,VEC3 i16n,VEC3 u16,VEC3 u16n"},
    {"NORMAL", "VEC3 f32", "VEC3 i8n,VEC3 i16n"},
    {"TANGENT", "VEC4 f32", "VEC4 i8n,VEC4 i16n"},
    {"TEXCOORD_", "VEC2 f32,VEC2 u8n,VEC2 u16n", "VEC2 i8,VEC2 i8n,VEC2 u8,VEC2 i16,VEC2 i16n,VEC2 u16"},
    {"COLOR_", "VEC3 f32,VEC3 u8n,VEC3 u16n,VEC4 f32,VEC4 u8n,VEC4 u16n", ""},
    {"JOINTS_", "VEC4 u8,VEC4 u16", ""},
    {"WEIGHTS_", "VEC4 f32,VEC4 u8n,VEC4 u16n", ""}};
constexpr Semantic kTargetAttributes[] = {
    {"POSITION", "VEC3 f32", "VEC3 i8,VEC3 i8n,VEC3 i16,VEC3 i16n"},
    {"NORMAL", "VEC3 f32", "VEC3 i8n,VEC3 i16n"},
    {"TANGENT", "VEC3 f32", "VEC3 i8n,VEC3 i16n"},
    {"TEXCOORD_", "VEC2 f32,VEC2 i8n,VEC2 u8n,VEC2 i16n,VEC2 u16n", "VEC2 i8,VEC2 i16,VEC2 u8,VEC2 u16"},
    {"COLOR_",
     "VEC3 f32,VEC3 i8n,VEC3 u8n,VEC3 i16n,VEC3 u16n,VEC4 f32,VEC4 i8n,VEC4 u8n,VEC4 i16n,VEC4 u16n", ""}};

constexpr std::string_view kIndexFormats = "SCALAR u8,SCALAR u16,SCALAR u32";

bool lists(std::string_view formats, std::string_view format) {
  while (!formats.empty()) {
    const std::size_t end = std::min(formats.find(','), formats.size());
    if (formats.substr(0, end) == format) return true;
    formats.remove_prefix(std::min(end + 1, formats.size()));
  }
  return false;
}

bool is_number(std::string_view text) {
  return !text.empty() && (text == "0" || text.front() != '0') &&
         text.find_first_not_of("0123456789") == std::string_view::npos;
}

class MeshCheck {
 public:
  MeshCheck(Context& context, AccessorTable& accessors, AccessorUses& uses)
      : context_(context), accessors_(accessors), uses_(uses) {
    const Json* used = member(&context.document, "extensionsUsed");
    is_quantized_ = used != nullptr && std::ranges::find(*used, Json("KHR_mesh_quantization")) != used->end();
  }

  void check(std::size_t mesh) {
    const Json& json = *element(&context_.document, "meshes", mesh);
    const std::string place = below("/meshes", mesh);
    const std::size_t targets = size_of(element(&json, "primitives", 0), "targets");
    for (std::size_t p = 0; p < size_of(&json, "primitives") && !context_.diagnostics.full(); ++p) {
      const Json& primitive = *element(&json, "primitives", p);
      const std::string at = below(below(place, "primitives"), p);
      check_primitive(primitive, at);
      if (size_of(&primitive, "targets") != targets)
        context_.error(at, concat("it has ", size_of(&primitive, "targets"),
                                  " morph targets, primitive 0 has ", targets));
    }
    if (const std::size_t weights = size_of(&json, "weights"); weights != 0 && weights != targets)
      context_.error(below(place, "weights"), concat(weights, " weights of ", targets, " morph targets"));
  }

 private:
  void check_primitive(const Json& primitive, const std::string& place) {
    const Json& attributes = *member(&primitive, "attributes");
    const std::string at = below(place, "attributes");
    std::map<std::string, std::size_t> set_counts;
    for (const auto& [name, index] : attributes.items()) {
      check_attribute(name, static_cast<std::size_t>(index.get<double>()), kAttributes, below(at, name));
      if (const std::size_t end = name.find('_'); end != std::string::npos && end > 0)
        ++set_counts[name.substr(0, end + 1)];
    }
    for (const auto& [semantic, count] : set_counts) {
      for (std::size_t i = 0; i < count; ++i) {
        if (!attributes.contains(concat(semantic, i)))
          context_.error(
              at, concat("the numbers of ", semantic, " do not go from 0 on: ", semantic, i, " is missing"));
      }
    }
    if (set_counts["JOINTS_"] != set_counts["WEIGHTS_"])
      context_.error(
          at, concat(set_counts["JOINTS_"], " sets of joints, but ", set_counts["WEIGHTS_"], " of weights"));
    const std::size_t vertices = check_counts(attributes, at);
    check_indices(primitive, vertices, place);
    for (std::size_t t = 0; t < size_of(&primitive, "targets") && !context_.diagnostics.full(); ++t)
      check_target(*element(&primitive, "targets", t), attributes, below(below(place, "targets"), t));
    if (const auto material = index_of(&primitive, "material"))
      check_texture_sets(*material, attributes, place);
  }

  void check_attribute(const std::string& name, std::size_t accessor, std::span<const Semantic> semantics,
                       const std::string& place) {
    if (name.starts_with('_')) {
      uses_.add(accessor, Usage::kVertices, place);
      return;
    }
    const auto known = std::ranges::find_if(semantics, [&](const Semantic& semantic) {
      return semantic.name.ends_with('_') ? name.starts_with(semantic.name) &&
                                                is_number(std::string_view(name).substr(semantic.name.size()))
                                          : name == semantic.name;
    });
    if (known == semantics.end()) {
      context_.error(place, "glTF has no such attribute: names of one's own begin with '_'");
      return;
    }
    uses_.add(accessor, Usage::kVertices, place);
    const std::string& format = accessors_[accessor].format;
    if (!lists(known->formats, format) && !(is_quantized_ && lists(known->quantized, format)))
      context_.error(
          place, concat("accessor ", accessor, " is ", format, ", not one of ", std::string(known->formats),
                        is_quantized_ ? concat(",", std::string(known->quantized)) : ""));
    const Json* json = element(&context_.document, "accessors", accessor);
    if (name == "POSITION" && (member(json, "min") == nullptr || member(json, "max") == nullptr))
      context_.error(place, concat("accessor ", accessor, " has positions, but no min and max"));
    check_alignment(accessor, place);
    if (semantics.data() != kAttributes) return;
    if (name == "NORMAL") uses_.demands(accessor).unit_vectors = true;
    if (name == "TANGENT") uses_.demands(accessor).tangents = true;
  }

  /// Vertices begin at multiples of four bytes.
  void check_alignment(std::size_t accessor, const std::string& place) {
    const Json* json = element(&context_.document, "accessors", accessor);
    const auto view = index_of(json, "bufferView");
    if (!view) return;
    const Json* view_json = element(&context_.document, "bufferViews", *view);
    constexpr std::size_t kWord = 4;
    const auto size =
        static_cast<std::size_t>(accessors_[accessor].components) * accessors_[accessor].component_size();
    const bool is_tight = member(view_json, "byteStride") == nullptr &&
                          extension(view_json, "EXT_meshopt_compression") == nullptr;
    if (size_member(*json, "byteOffset") % kWord != 0 ||
        (size_member(*view_json, "byteOffset") + size_member(*json, "byteOffset")) % kWord != 0 ||
        (is_tight && size % kWord != 0))
      context_.error(
          place, concat("the elements of accessor ", accessor, " do not begin at multiples of four bytes"));
  }

  /// The number of vertices.
  std::size_t check_counts(const Json& attributes, const std::string& place) {
    const std::size_t count = accessors_[static_cast<std::size_t>(attributes.begin()->get<double>())].count;
    for (const auto& [name, index] : attributes.items()) {
      const std::size_t own = accessors_[static_cast<std::size_t>(index.get<double>())].count;
      if (own != count)
        context_.error(below(place, name),
                       concat(own, " elements, but ", attributes.begin().key(), " has ", count));
    }
    return count;
  }

  void check_indices(const Json& primitive, std::size_t vertices, const std::string& place) {
    const auto index = index_of(&primitive, "indices");
    if (!index) return;
    const std::string at = below(place, "indices");
    uses_.add(*index, Usage::kIndices, at);
    if (const std::string& format = accessors_[*index].format; !lists(kIndexFormats, format)) {
      context_.error(
          at, concat("accessor ", *index, " is ", format, ", not one of ", std::string(kIndexFormats)));
      return;
    }
    Demands& demands = uses_.demands(*index);
    demands.vertices = std::min<std::uint64_t>(demands.vertices, vertices);
  }

  void check_target(const Json& target, const Json& attributes, const std::string& place) {
    for (const auto& [name, index] : target.items()) {
      const auto accessor = static_cast<std::size_t>(index.get<double>());
      const std::string at = below(place, name);
      check_attribute(name, accessor, kTargetAttributes, at);
      const auto base = index_of(&attributes, name.c_str());
      if (!base) {
        context_.error(at, "the primitive itself has no such attribute");
      } else if (accessors_[*base].count != accessors_[accessor].count) {
        context_.error(at, concat(accessors_[accessor].count, " elements, but the primitive has ",
                                  accessors_[*base].count));
      }
    }
  }

  /// Textures have coordinates that the primitive has.
  void check_texture_sets(std::size_t material, const Json& attributes, const std::string& place) {
    const auto look = [&](const Json& object, const std::string& at) {
      for (const auto& [name, value] : object.items()) {
        if (!name.ends_with("Texture") || !value.is_object() || !value.contains("index")) continue;
        const std::string needed = concat("TEXCOORD_", TextureUse{&value, below(at, name)}.set());
        if (!attributes.contains(needed))
          context_.error(below(place, "material"),
                         concat(below(at, name), " needs ", needed, ", which the primitive lacks"));
      }
    };
    const Json& json = *element(&context_.document, "materials", material);
    const std::string at = below("/materials", material);
    look(json, at);
    if (const Json* core = member(&json, "pbrMetallicRoughness"))
      look(*core, below(at, "pbrMetallicRoughness"));
    const Json* extensions = member(&json, "extensions");
    if (extensions == nullptr) return;
    for (const auto& [name, value] : extensions->items()) {
      if (find_schema(concat("material/", name)) != nullptr)
        look(value, below(below(at, "extensions"), name));
    }
  }

  Context& context_;
  AccessorTable& accessors_;
  AccessorUses& uses_;
  bool is_quantized_ = false;
};

}  // namespace mesh_rules

void check_meshes(Context& context, AccessorTable& accessors, AccessorUses& uses) {
  mesh_rules::MeshCheck check(context, accessors, uses);
  for (std::size_t m = 0; m < size_of(&context.document, "meshes") && !context.diagnostics.full(); ++m)
    check.check(m);
}

}  // namespace tessera::client::gltf
