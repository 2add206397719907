#include "import/mitsuba/matter/textures.h"

#include <algorithm>
#include <cctype>

#include "import/input/concat.h"

namespace tessera::client::mitsuba {
namespace {

/// (u, v) -> to_uv * (u, v), with what stands in a UvMapping when it is that. Then (u', v') -> (u', flipped)
/// where images want v to grow upwards.
void write_mapping(const Imath::M44d& to_uv, bool flip_v, v1::UvMapping& mapping) {
  const double sign = flip_v ? -1 : 1;
  const auto set = [](double value, double absent) { return value != absent; };
  if (set(to_uv[0][0], 1)) mapping.set_scale_u(static_cast<float>(to_uv[0][0]));
  if (set(sign * to_uv[1][1], 1)) mapping.set_scale_v(static_cast<float>(sign * to_uv[1][1]));
  mapping.set_u_from_v(static_cast<float>(to_uv[1][0]));
  mapping.set_v_from_u(static_cast<float>(sign * to_uv[0][1]));
  mapping.set_offset_u(static_cast<float>(to_uv[3][0]));
  mapping.set_offset_v(static_cast<float>(sign * to_uv[3][1] + (flip_v ? 1 : 0)));
}

/// Mitsuba takes integer images as sRGB, whatever their depth.
v1::ImageTexture::Encoding encoding_of(std::filesystem::path file, bool raw) {
  if (raw) return v1::ImageTexture::LINEAR;
  std::string ending = file.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const char* integer : {".png", ".jpg", ".jpeg", ".bmp", ".tga"}) {
    if (ending == integer) return v1::ImageTexture::SRGB;
  }
  return v1::ImageTexture::AUTO;
}

v1::SpectrumValue constant_value(const v1::Spectrum& spectrum) {
  v1::SpectrumValue value;
  *value.mutable_constant() = spectrum;
  return value;
}

}  // namespace

v1::SpectrumValue SceneTextures::color(PropertyReader& reader, std::string_view name, double fallback,
                                       ColorUse use) {
  const Property* property = reader.find(name);
  if (property == nullptr) return constant_value(rgb_spectrum({fallback, fallback, fallback}));
  if (const auto color = read_constant_color(reader, *property, use))
    return constant_value(color->to_spectrum());
  Object* const* object = std::get_if<Object*>(&property->value);
  if (object == nullptr || (*object)->tag != "texture") {
    reader.error(*property, "expected a colour or a texture");
    return constant_value(rgb_spectrum({fallback, fallback, fallback}));
  }
  v1::SpectrumValue value;
  value.set_texture(this->use(**object, TextureRole::kColor));
  return value;
}

v1::FloatValue SceneTextures::scalar(PropertyReader& reader, std::string_view name, double fallback) {
  v1::FloatValue value;
  value.set_constant(static_cast<float>(fallback));
  const Property* property = reader.find(name);
  if (property == nullptr) return value;
  if (const auto color = read_constant_color(reader, *property, ColorUse::kUnbounded)) {
    value.set_constant(static_cast<float>((color->rgb[0] + color->rgb[1] + color->rgb[2]) / 3));
    return value;
  }
  Object* const* object = std::get_if<Object*>(&property->value);
  if (object == nullptr || (*object)->tag != "texture") {
    reader.error(*property, "expected a number or a texture");
    return value;
  }
  value.set_texture(use(**object, TextureRole::kScalar));
  return value;
}

std::string SceneTextures::use(Object& texture, TextureRole role) {
  const auto known = names_.find({&texture, role});
  if (known != names_.end()) return known->second;
  const std::string name = Context::unique_name(texture, texture.type, taken_);
  names_[{&texture, role}] = name;
  v1::Texture message;
  message.set_name(name);
  PropertyReader reader(context_, texture);
  write(reader, role, message);
  v1::Texture& added = *context_.scene.add_textures();
  added = std::move(message);
  context_.note(added, texture);
  return name;
}

std::string SceneTextures::add_product(const v1::SpectrumValue& value, const v1::SpectrumValue& factor) {
  v1::Texture& message = *context_.scene.add_textures();
  std::string name = "product";
  for (int i = 2; !taken_.insert(name).second; ++i) name = concat("product-", i);
  message.set_name(name);
  *message.mutable_scale()->mutable_value() = value;
  *message.mutable_scale()->mutable_factor() = factor;
  return name;
}

void SceneTextures::set_normal_map(PropertyReader& owner, const Property& property, v1::Material& material) {
  Object& texture = *std::get<Object*>(property.value);
  if (const auto color = read_constant_color(owner, property, ColorUse::kUnbounded)) {
    v1::Texture& message = *context_.scene.add_textures();
    message.set_name(Context::unique_name(texture, texture.type, taken_));
    *message.mutable_constant() = rgb_spectrum(color->rgb);
    material.set_normal_texture(message.name());
    return;
  }
  if (texture.type != "bitmap") {
    material.set_normal_texture(use(texture, TextureRole::kNormals));
    return;
  }
  PropertyReader reader(context_, texture);
  v1::ImageTexture& image = *material.mutable_normal_map();
  write_image(reader, image);
  if (image.encoding() == v1::ImageTexture::LINEAR) return;
  reader.warn("a normal map without raw=true: its values are taken as they stand in the file all the same");
  image.set_encoding(v1::ImageTexture::LINEAR);
}

void SceneTextures::write(PropertyReader& reader, TextureRole role, v1::Texture& message) {
  const std::string& type = reader.object().type;
  if (type == "bitmap") {
    write_image(reader, *message.mutable_image());
  } else if (type == "checkerboard") {
    write_checkerboard(reader, role, *message.mutable_checkerboard());
  } else if (type == "mesh_attribute") {
    const std::string name = reader.text("name", "");
    if (!name.starts_with("vertex_") && !name.starts_with("face_")) {
      reader.error(
          concat("a mesh attribute's name begins with \"vertex_\" or \"face_\", but this is \"", name, "\""));
    }
    message.mutable_mesh_attribute()->set_attribute(name);
    const double scale = reader.number("scale", 1);
    if (scale != 1) message.mutable_mesh_attribute()->set_scale(static_cast<float>(scale));
  } else {
    reader.error(
        concat("texture \"", type,
               "\" is not supported: expected bitmap, checkerboard, mesh_attribute, uniform, srgb, d65, "
               "rawconstant, regular, irregular or blackbody"));
  }
}

void SceneTextures::write_image(PropertyReader& reader, v1::ImageTexture& image) {
  if (const std::optional<std::filesystem::path> path = reader.file("filename")) {
    absl::StatusOr<v1::BlobRef> blob = context_.blobs.add_file(*path, reader.text("filename", ""));
    if (blob.ok()) {
      *image.mutable_image() = *blob;
    } else {
      reader.error(*reader.find("filename"), std::string(blob.status().message()));
    }
    image.set_encoding(encoding_of(*path, reader.boolean("raw", false)));
  }
  const std::string wrap = reader.keyword("wrap_mode", "repeat");
  if (wrap == "repeat") {
    image.set_wrap(v1::ImageTexture::REPEAT);
  } else if (wrap == "mirror") {
    image.set_wrap(v1::ImageTexture::MIRROR);
  } else if (wrap == "clamp") {
    image.set_wrap(v1::ImageTexture::CLAMP);
  } else {
    reader.error(*reader.find("wrap_mode"), concat("expected repeat, mirror or clamp, found \"", wrap, "\""));
  }
  // Mitsuba 3 has no others; those of 0.6 are pyramids.
  const std::string filter = reader.keyword("filter_type", "");
  if (filter == "nearest") {
    image.set_filter(v1::ImageTexture::NEAREST);
  } else if (filter == "bilinear") {
    image.set_filter(v1::ImageTexture::BILINEAR);
  } else if (!filter.empty()) {
    reader.error(*reader.find("filter_type"), concat("expected bilinear or nearest, found \"", filter, "\""));
  }
  // Mitsuba's v grows down the image.
  write_mapping(reader.transform("to_uv"), true, *image.mutable_mapping());
  // How Mitsuba stores and filters the image in its own memory.
  reader.ignore({"format", "accel", "raw"});
}

v1::SpectrumValue SceneTextures::value_of_role(PropertyReader& reader, std::string_view name, double fallback,
                                               TextureRole role) {
  if (role != TextureRole::kScalar) {
    return color(reader, name, fallback,
                 role == TextureRole::kColor ? ColorUse::kReflectance : ColorUse::kUnbounded);
  }
  const v1::FloatValue number = scalar(reader, name, fallback);
  v1::SpectrumValue value;
  if (number.kind_case() == v1::FloatValue::kTexture) {
    value.set_texture(number.texture());
  } else {
    *value.mutable_constant() = constant_spectrum(number.constant());
  }
  return value;
}

void SceneTextures::write_checkerboard(PropertyReader& reader, TextureRole role,
                                       v1::CheckerboardTexture& board) {
  const v1::SpectrumValue color0 = value_of_role(reader, "color0", 0.4, role);
  const v1::SpectrumValue color1 = value_of_role(reader, "color1", 0.2, role);
  // Asked for a colour, Mitsuba gives color0 where both coordinates are in the same half of their cell; asked
  // for a number, it gives color1 there.
  *board.mutable_even() = role == TextureRole::kScalar ? color1 : color0;
  *board.mutable_odd() = role == TextureRole::kScalar ? color0 : color1;
  // Mitsuba's cells are half a unit wide.
  write_mapping(reader.transform("to_uv") * scaling(2, 2, 1), false, *board.mutable_mapping());
}

}  // namespace tessera::client::mitsuba
