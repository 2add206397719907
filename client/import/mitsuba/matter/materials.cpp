#include "import/mitsuba/matter/materials.h"

#include <utility>

#include "import/input/concat.h"
#include "import/mitsuba/matter/colors.h"
#include "wire/scene_numbers.h"

namespace tessera::client::mitsuba {
namespace {

v1::SpectrumValue as_spectrum(const v1::FloatValue& number) {
  v1::SpectrumValue value;
  if (number.has_texture()) {
    value.set_texture(number.texture());
  } else {
    *value.mutable_constant() = constant_spectrum(number.constant());
  }
  return value;
}

}  // namespace

std::string MaterialTable::use_default(bool emits) {
  const std::string name = emits ? "default-black" : "default-diffuse";
  const auto [entry, is_new] = names_.try_emplace(Key{nullptr, emits, ""}, name);
  if (!is_new) return entry->second;
  entry->second = name;
  for (int i = 2; !taken_.insert(entry->second).second; ++i) entry->second = concat(name, "-", i);
  v1::Material& material = *context_.scene.add_materials();
  material.set_name(entry->second);
  const double reflectance = emits ? 0 : 0.5;
  *material.mutable_diffuse()->mutable_reflectance()->mutable_constant() =
      rgb_spectrum({reflectance, reflectance, reflectance});
  material.set_one_sided(true);
  return entry->second;
}

std::string MaterialTable::use(Object& bsdf, const Wrapping& wrapping) {
  const Key key = {&bsdf, wrapping.two_sided, wrapping.fields.SerializeAsString()};
  const auto known = names_.find(key);
  if (known != names_.end()) return known->second;
  // Where wrappers share what they wrap, the ways through them may double with every level.
  const std::size_t most = 4096 + 16 * context_.document.objects.size();
  if (names_.size() >= most && !std::exchange(too_many_names_, true)) {
    context_.diagnostics.error(
        bsdf.where, concat("the ", bsdf.title(), " and other bsdfs are shared by so many masks, maps and ",
                           "blends of one another that they make more than ", most, " materials"));
  }
  if (too_many_names_) return "";
  return names_[key] = write(bsdf, wrapping);
}

std::string MaterialTable::write(Object& bsdf, const Wrapping& wrapping) {
  PropertyReader reader(context_, bsdf);
  std::string name;
  if (bsdf.type == "twosided") {
    name = write_two_sided(reader, wrapping);
  } else if (bsdf.type == "mask") {
    name = write_mask(reader, wrapping);
  } else if (bsdf.type == "bumpmap") {
    name = write_bump_map(reader, wrapping);
  } else if (bsdf.type == "normalmap") {
    name = write_normal_map(reader, wrapping);
  } else if (bsdf.type == "blendbsdf") {
    name = write_blend(reader, wrapping);
  } else {
    name = write_leaf(reader, wrapping);
  }
  return name;
}

std::string MaterialTable::write_leaf(PropertyReader& reader, const Wrapping& wrapping) {
  const Object& bsdf = reader.object();
  const BsdfType* type = find_bsdf_type(bsdf.type);
  if (type == nullptr) {
    reader.error(concat("bsdf \"", bsdf.type, "\" is not supported: expected ", names_of_bsdf_types(),
                        ", twosided, mask, blendbsdf, bumpmap or normalmap"));
    for (const Property& property : bsdf.properties) reader.ignore({property.name});
    return "";
  }
  v1::Material material = wrapping.fields;
  type->write(reader, textures_, material);
  if (const std::string fault = wire::index_fault(material); !fault.empty())
    reader.error(concat(bsdf.title(), ": ", fault));
  const bool transmits = type->transmits || (bsdf.type == "principled" && reader.has("spec_trans"));
  material.set_one_sided(!transmits && !wrapping.two_sided);
  material.set_name(Context::unique_name(bsdf, bsdf.type, taken_));
  v1::Material& added = *context_.scene.add_materials();
  added = std::move(material);
  context_.note(added, bsdf);
  return added.name();
}

std::string MaterialTable::use_only_child(PropertyReader& reader, const Wrapping& wrapping) {
  Object* child = reader.child("bsdf");
  if (child != nullptr) return use(*child, wrapping);
  reader.error(concat(reader.object().title(), ": expected a bsdf inside"));
  return "";
}

std::string MaterialTable::write_two_sided(PropertyReader& reader, Wrapping wrapping) {
  const std::vector<Property*> sides = reader.children("bsdf");
  if (sides.empty() || sides.size() > 2) {
    reader.error(concat("bsdf \"twosided\": expected one or two bsdfs inside, found ", sides.size()));
    return "";
  }
  if (sides.size() == 2) {
    Wrapping back = wrapping;
    back.two_sided = true;
    back.fields.clear_back();
    wrapping.fields.set_back(use(*std::get<Object*>(sides[1]->value), back));
  } else {
    wrapping.two_sided = true;
  }
  return use(*std::get<Object*>(sides[0]->value), wrapping);
}

std::string MaterialTable::write_mask(PropertyReader& reader, Wrapping wrapping) {
  const v1::FloatValue opacity = textures_.scalar(reader, "opacity", 0.5);
  if (wrapping.fields.has_opacity()) {
    const std::string product =
        textures_.add_product(as_spectrum(wrapping.fields.opacity()), as_spectrum(opacity));
    wrapping.fields.mutable_opacity()->set_texture(product);
  } else {
    *wrapping.fields.mutable_opacity() = opacity;
  }
  return use_only_child(reader, wrapping);
}

/// Reads what Mitsuba is to do about normals that a map has turned too far, since version 3.7.1.
void MaterialTable::read_map_options(PropertyReader& reader) {
  for (const char* option : {"flip_invalid_normals", "use_shadowing_function"}) {
    if (!reader.boolean(option, true))
      reader.warn(concat(option, " = false is not supported: it is true, as by default"));
  }
}

std::string MaterialTable::write_bump_map(PropertyReader& reader, Wrapping wrapping) {
  Object* texture = reader.child("texture");
  const double scale = reader.number("scale", 1);
  read_map_options(reader);
  if (texture == nullptr) {
    reader.error("bsdf \"bumpmap\": expected a texture inside");
  } else if (read_constant_color(reader, *reader.children("texture").front(), ColorUse::kUnbounded)) {
    reader.warn("a bumpmap of the same height everywhere bends nothing: it is left out");
  } else if (wrapping.fields.has_displacement()) {
    reader.warn("a bumpmap inside a bumpmap is left out");
  } else {
    v1::SpectrumValue height;
    height.set_texture(textures_.use(*texture, TextureRole::kScalar));
    v1::SpectrumValue factor;
    *factor.mutable_constant() = constant_spectrum(scale);
    wrapping.fields.set_bends_softly(true);
    wrapping.fields.mutable_displacement()->set_texture(scale == 1 ? height.texture()
                                                                   : textures_.add_product(height, factor));
  }
  return use_only_child(reader, wrapping);
}

std::string MaterialTable::write_normal_map(PropertyReader& reader, Wrapping wrapping) {
  Object* texture = reader.named_child("normalmap", "texture");
  read_map_options(reader);
  if (texture == nullptr) {
    reader.error("bsdf \"normalmap\": expected a texture \"normalmap\"");
  } else if (wrapping.fields.has_normal_map() || !wrapping.fields.normal_texture().empty()) {
    reader.warn("a normalmap inside a normalmap is left out");
  } else {
    textures_.set_normal_map(reader, *reader.find("normalmap"), wrapping.fields);
    wrapping.fields.set_bends_softly(true);
  }
  return use_only_child(reader, wrapping);
}

std::string MaterialTable::write_blend(PropertyReader& reader, const Wrapping& wrapping) {
  const std::vector<Property*> parts = reader.children("bsdf");
  if (parts.size() != 2) {
    reader.error(concat("bsdf \"blendbsdf\": expected two bsdfs inside, found ", parts.size()));
    return "";
  }
  v1::Material material;
  v1::MixMaterial& mix = *material.mutable_mix();
  mix.set_a(use(*std::get<Object*>(parts[0]->value), wrapping));
  mix.set_b(use(*std::get<Object*>(parts[1]->value), wrapping));
  if (!reader.has("weight")) reader.error("bsdf \"blendbsdf\": expected a parameter \"weight\"");
  *mix.mutable_amount() = textures_.scalar(reader, "weight", 0.5);
  material.set_name(Context::unique_name(reader.object(), "blendbsdf", taken_));
  v1::Material& added = *context_.scene.add_materials();
  added = std::move(material);
  context_.note(added, reader.object());
  return added.name();
}

}  // namespace tessera::client::mitsuba
