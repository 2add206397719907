#include "import/pbrt/matter/materials.h"

#include "import/input/concat.h"
#include "import/pbrt/matter/material_writers.h"
#include "wire/limits.h"
#include "wire/scene_numbers.h"

namespace tessera::client::pbrt {

int MaterialTable::add(std::string name, const std::string& type, ParameterList parameters) {
  if (find_material_writer(type) == nullptr) {
    context_.diagnostics.error(parameters.where(), concat("unknown material type \"", type, "\": expected ",
                                                          names_of_material_types()));
  }
  entries_.push_back({std::move(name), type, std::move(parameters), State::kDefined});
  return static_cast<int>(entries_.size()) - 1;
}

void MaterialTable::define_named(const std::string& name, ParameterList parameters) {
  const SourceLocation where = parameters.where();
  if (!parameters.has("type")) {
    context_.diagnostics.error(where, concat("material \"", name, "\": expected \"string type\""));
    return;
  }
  if (named_.contains(name)) {
    context_.diagnostics.error(where, concat("material \"", name, "\" is defined a second time"));
    return;
  }
  const std::string type = parameters.get_string("type", "", context_.diagnostics);
  named_[name] = add(name, type, std::move(parameters));
}

int MaterialTable::define_anonymous(const std::string& type, ParameterList parameters) {
  return add("", type, std::move(parameters));
}

bool MaterialTable::is_interface(const MaterialRef& ref) const {
  int index = ref.anonymous;
  if (const auto named = named_.find(ref.name); !ref.name.empty() && named != named_.end())
    index = named->second;
  if (index < 0) return false;
  const std::string& type = entries_[index].type;
  return type.empty() || type == "interface" || type == "none";
}

std::string MaterialTable::use(const MaterialRef& ref, SourceLocation where) {
  int index = ref.anonymous;
  if (!ref.name.empty()) {
    const auto named = named_.find(ref.name);
    if (named == named_.end()) {
      context_.diagnostics.error(where, concat("there is no material \"", ref.name, "\""));
      return "";
    }
    index = named->second;
  }
  if (index < 0) return "";
  Entry& entry = entries_[index];
  if (entry.state == State::kInProgress) {
    context_.diagnostics.error(where, concat("material \"", entry.name, "\" is a mix of itself"));
  } else if (entry.state == State::kDefined && nesting_ > wire::kMaxNesting) {
    context_.diagnostics.error(where, concat("material \"", entry.name, "\": more than ", wire::kMaxNesting,
                                             " mixes within one another"));
  } else if (entry.state == State::kDefined) {
    entry.state = State::kInProgress;
    ++nesting_;
    convert(entry);
    --nesting_;
    entry.state = State::kDone;
  }
  return entry.name;
}

void MaterialTable::convert(Entry& entry) {
  const MaterialWriter write = find_material_writer(entry.type);
  if (write == nullptr) return;  // reported where it is defined
  v1::Material material;
  ValueReader values(context_, textures_, entry.parameters);
  write(
      values,
      [&](const std::string& name, SourceLocation where) {
        return use({-1, name}, where);
      },
      material);
  if (const std::string fault = wire::index_fault(material); !fault.empty()) fail(values, fault);
  if (entry.parameters.has("displacement"))
    *material.mutable_displacement() = values.number("displacement", 0);
  // pbrt takes files only.
  if (std::optional<std::string> texture = values.texture("normalmap")) {
    material.set_normal_texture(*std::move(texture));
  } else if (std::optional<v1::BlobRef> image = values.image("normalmap")) {
    *material.mutable_normal_map()->mutable_image() = *std::move(image);
    material.mutable_normal_map()->set_encoding(v1::ImageTexture::LINEAR);
  }

  // Exporters repeat materials in place over and over: equal ones become one.
  if (entry.name.empty()) {
    std::string fresh = concat("material ", context_.scene.materials_size());
    while (named_.contains(fresh)) fresh += "'";
    const auto [content, is_new] = scene_name_of_content_.try_emplace(material.SerializeAsString(), fresh);
    entry.name = content->second;
    if (!is_new) return;
  }
  material.set_name(entry.name);
  v1::Material& added = *context_.scene.add_materials();
  added = std::move(material);
  context_.note(added, entry.parameters.where(), concat("material (", added.name(), "): "));
}

}  // namespace tessera::client::pbrt
