#include "import/pbrt/matter/texture_writers.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "import/input/concat.h"
#include "import/pbrt/file/tokenizer.h"
#include "wire/limits.h"

namespace tessera::client::pbrt {
namespace {

using wire::kMaxAnisotropy;

/// A value of the texture's own kind: a float texture's values are floats (or float textures), as spectra.
v1::SpectrumValue value_of_kind(TextureKind kind, ValueReader& values, std::string_view name,
                                double fallback) {
  if (kind == TextureKind::kSpectrum) return values.spectrum(name, fallback, SpectrumUse::kUnbounded);
  const v1::FloatValue number = values.number(name, fallback);
  v1::SpectrumValue value;
  if (number.kind_case() == v1::FloatValue::kTexture) {
    value.set_texture(number.texture());
  } else {
    *value.mutable_constant() = constant_spectrum(number.constant());
  }
  return value;
}

Imath::V3d read_vector(ValueReader& values, std::string_view name, const Imath::V3d& fallback) {
  const Parameter* parameter =
      values.parameters().find(name, {ParameterType::kVector3}, values.diagnostics());
  if (parameter == nullptr || parameter->numbers.size() != 3) return fallback;
  return {parameter->numbers[0], parameter->numbers[1], parameter->numbers[2]};
}

/// world -> texture space; the identity, with an error, where the transformation is singular.
Imath::M44d texture_from_world(const TextureInput& in) {
  const std::optional<Imath::M44d> result = inverse(in.world_from_texture);
  if (!result) {
    in.values.diagnostics().error(in.values.parameters().where(),
                                  concat(in.values.parameters().owner(), ": its transformation is singular"));
  }
  return result.value_or(Imath::M44d{});
}

void write_planar_mapping(const TextureInput& in, v1::UvMapping& mapping) {
  const Imath::V3d v1 = read_vector(in.values, "v1", {1, 0, 0}), v2 = read_vector(in.values, "v2", {0, 1, 0});
  Imath::M44d plane_from_texture;
  for (int i = 0; i < 3; ++i) {
    plane_from_texture[i][0] = v1[i];
    plane_from_texture[i][1] = v2[i];
  }
  mapping.set_source(v1::UvMapping::PLANAR);
  write_matrix(texture_from_world(in) * plane_from_texture, *mapping.mutable_texture_from_world());
  mapping.set_offset_u(static_cast<float>(in.values.get_float("udelta", 0)));
  mapping.set_offset_v(static_cast<float>(in.values.get_float("vdelta", 0)));
}

void write_mapping(const TextureInput& in, v1::UvMapping& mapping) {
  ValueReader& values = in.values;
  const std::string type = values.get_string("mapping", "uv");
  if (type == "spherical") {
    mapping.set_source(v1::UvMapping::SPHERICAL);
    write_matrix(texture_from_world(in), *mapping.mutable_texture_from_world());
  } else if (type == "cylindrical") {
    // pbrt's angle begins on the other side of the axis.
    mapping.set_source(v1::UvMapping::CYLINDRICAL);
    write_matrix(texture_from_world(in) * scaling(-1, -1, 1), *mapping.mutable_texture_from_world());
  } else if (type == "planar") {
    write_planar_mapping(in, mapping);
  } else {
    if (type != "uv") {
      values.diagnostics().error(
          values.parameters().where(),
          concat("unknown texture mapping \"", type, "\": expected uv, spherical, cylindrical or planar"));
    }
    const double scale_u = values.get_float("uscale", 1), scale_v = values.get_float("vscale", 1);
    if (scale_u != 1) mapping.set_scale_u(static_cast<float>(scale_u));
    if (scale_v != 1) mapping.set_scale_v(static_cast<float>(scale_v));
    mapping.set_offset_u(static_cast<float>(values.get_float("udelta", 0)));
    mapping.set_offset_v(static_cast<float>(values.get_float("vdelta", 0)));
  }
}

void write_encoding(ValueReader& values, v1::ImageTexture& image) {
  const std::string encoding = values.get_string("encoding", "");
  if (encoding.empty()) return;  // AUTO is pbrt's default too
  if (encoding == "linear") {
    image.set_encoding(v1::ImageTexture::LINEAR);
  } else if (encoding == "sRGB") {
    image.set_encoding(v1::ImageTexture::SRGB);
  } else if (const auto gamma =
                 encoding.starts_with("gamma ") ? parse_number(encoding.substr(6)) : std::nullopt) {
    image.set_encoding(v1::ImageTexture::GAMMA);
    image.set_gamma(static_cast<float>(*gamma));
  } else {
    values.diagnostics().error(
        values.parameters().where(),
        concat("unknown encoding \"", encoding, "\": expected sRGB, linear or \"gamma N\""));
  }
}

/// pbrt takes a level of the pyramid for "point" and "bilinear", too; here they are of full resolution, and
/// the pixel's own samples average them.
void write_filter(ValueReader& values, v1::ImageTexture& image) {
  constexpr std::pair<std::string_view, v1::ImageTexture::Filter> kFilters[] = {
      {"point", v1::ImageTexture::NEAREST},
      {"bilinear", v1::ImageTexture::BILINEAR},
      {"trilinear", v1::ImageTexture::TRILINEAR},
      {"EWA", v1::ImageTexture::EWA},
      {"ewa", v1::ImageTexture::EWA}};
  const std::string filter = values.get_string("filter", "");
  const auto known = std::ranges::find(kFilters, filter, [](const auto& pair) { return pair.first; });
  if (known != std::end(kFilters)) {
    image.set_filter(known->second);
  } else if (!filter.empty()) {
    values.warn(concat("texture filter \"", filter, "\" is not known: it is filtered as if it named none"));
  }
  const double max_anisotropy = values.get_float("maxanisotropy", 8);
  if (image.filter() != v1::ImageTexture::EWA || max_anisotropy == 8) return;
  if (max_anisotropy >= 1 && max_anisotropy <= kMaxAnisotropy) {
    image.set_max_anisotropy(static_cast<float>(max_anisotropy));
  } else {
    values.warn(
        concat("a maxanisotropy of ", max_anisotropy, " is not from 1 to ", kMaxAnisotropy, ": 8 is used"));
  }
}

void write_imagemap(const TextureInput& in, v1::Texture& texture) {
  ValueReader& values = in.values;
  v1::ImageTexture& image = *texture.mutable_image();
  if (std::optional<v1::BlobRef> blob = values.image("filename")) *image.mutable_image() = *std::move(blob);
  write_encoding(values, image);

  const std::string wrap = values.get_string("wrap", "repeat");
  if (wrap == "repeat")
    image.set_wrap(v1::ImageTexture::REPEAT);
  else if (wrap == "clamp")
    image.set_wrap(v1::ImageTexture::CLAMP);
  else if (wrap == "black")
    image.set_wrap(v1::ImageTexture::BLACK);
  else
    values.warn(concat("texture wrap mode \"", wrap, "\" is not supported: the image is repeated"));

  write_filter(values, image);

  const double scale = values.get_float("scale", 1);
  if (scale != 1) image.set_scale(static_cast<float>(scale));
  image.set_invert(values.get_bool("invert", false));
  write_mapping(in, *image.mutable_mapping());
}

void write_constant(const TextureInput& in, v1::Texture& texture) {
  *texture.mutable_constant() = in.kind == TextureKind::kSpectrum
                                    ? in.values.plain_spectrum("value", 1, SpectrumUse::kUnbounded)
                                    : constant_spectrum(in.values.get_float("value", 1));
}

void write_scale(const TextureInput& in, v1::Texture& texture) {
  *texture.mutable_scale()->mutable_value() = value_of_kind(in.kind, in.values, "tex", 1);
  *texture.mutable_scale()->mutable_factor() = value_of_kind(TextureKind::kFloat, in.values, "scale", 1);
}

void write_mix(const TextureInput& in, v1::Texture& texture) {
  *texture.mutable_mix()->mutable_a() = value_of_kind(in.kind, in.values, "tex1", 0);
  *texture.mutable_mix()->mutable_b() = value_of_kind(in.kind, in.values, "tex2", 1);
  *texture.mutable_mix()->mutable_amount() = in.values.number("amount", 0.5);
}

void write_checkerboard(const TextureInput& in, v1::Texture& texture) {
  v1::CheckerboardTexture& board = *texture.mutable_checkerboard();
  *board.mutable_even() = value_of_kind(in.kind, in.values, "tex1", 1);
  *board.mutable_odd() = value_of_kind(in.kind, in.values, "tex2", 0);
  const std::int64_t dimension = in.values.get_integer("dimension", 2);
  if (dimension == 3) {
    board.set_solid(true);
    write_matrix(texture_from_world(in), *board.mutable_mapping()->mutable_texture_from_world());
    return;
  }
  if (dimension != 2) {
    in.values.diagnostics().error(in.values.parameters().where(),
                                  concat("checkerboard: expected dimension 2 or 3, found ", dimension));
  }
  write_mapping(in, *board.mutable_mapping());
}

void write_direction_mix(const TextureInput& in, v1::Texture& texture) {
  v1::DirectionMixTexture& mix = *texture.mutable_direction_mix();
  *mix.mutable_a() = value_of_kind(in.kind, in.values, "tex1", 0);
  *mix.mutable_b() = value_of_kind(in.kind, in.values, "tex2", 1);
  const Imath::V3d d = transformed_vector(read_vector(in.values, "dir", {0, 1, 0}), in.world_from_texture);
  const double length = std::hypot(d[0], d[1], d[2]);
  if (!(length > 0)) {
    in.values.diagnostics().error(in.values.parameters().where(), "directionmix: \"dir\" has no direction");
    return;
  }
  mix.mutable_direction()->set_x(d[0] / length);
  mix.mutable_direction()->set_y(d[1] / length);
  mix.mutable_direction()->set_z(d[2] / length);
}

void write_dots(const TextureInput& in, v1::Texture& texture) {
  // pbrt-v4 hands the two over in the wrong order: its dots have the colour that is called "outside".
  *texture.mutable_dots()->mutable_inside() = value_of_kind(in.kind, in.values, "outside", 0);
  *texture.mutable_dots()->mutable_outside() = value_of_kind(in.kind, in.values, "inside", 1);
  write_mapping(in, *texture.mutable_dots()->mutable_mapping());
}

/// Four texels between which the renderer interpolates: (u, v) in the unit square lies between their centres.
void write_bilerp(const TextureInput& in, v1::Texture& texture) {
  std::vector<float> pfm;  // rows from the bottom
  for (const auto& [corner, fallback] : {std::pair{"v00", 0.0}, {"v10", 0.0}, {"v01", 1.0}, {"v11", 1.0}}) {
    const v1::Spectrum value = in.kind == TextureKind::kSpectrum
                                   ? in.values.plain_spectrum(corner, fallback, SpectrumUse::kUnbounded)
                                   : constant_spectrum(in.values.get_float(corner, fallback));
    for (const double component : linear_rgb_of(value)) pfm.push_back(static_cast<float>(component));
  }
  std::string file = "PF\n2 2\n-1.0\n";
  file.append(reinterpret_cast<const char*>(pfm.data()), pfm.size() * sizeof(float));
  v1::ImageTexture& image = *texture.mutable_image();
  *image.mutable_image() = in.values.context().blobs.add_bytes(std::move(file));
  image.mutable_image()->set_path("bilerp.pfm");
  image.set_wrap(v1::ImageTexture::CLAMP);
  image.set_filter(v1::ImageTexture::BILINEAR);  // texels are as wide as the texture
  v1::UvMapping& mapping = *image.mutable_mapping();
  write_mapping(in, mapping);
  mapping.set_scale_u(0.5f * (mapping.has_scale_u() ? mapping.scale_u() : 1));
  mapping.set_scale_v(0.5f * (mapping.has_scale_v() ? mapping.scale_v() : 1));
  mapping.set_offset_u(0.25f + 0.5f * mapping.offset_u());
  mapping.set_offset_v(0.25f + 0.5f * mapping.offset_v());
}

template <v1::NoiseTexture::Kind kKind>
void write_noise(const TextureInput& in, v1::Texture& texture) {
  v1::NoiseTexture& noise = *texture.mutable_noise();
  noise.set_kind(kKind);
  write_matrix(texture_from_world(in), *noise.mutable_texture_from_world());
  if (kKind == v1::NoiseTexture::WINDY) return;
  const std::int64_t octaves = in.values.get_integer("octaves", 8);
  if (octaves < 0 || octaves > 64) {
    in.values.diagnostics().error(in.values.parameters().where(),
                                  concat(octaves, " octaves: expected 0 to 64"));
    return;
  }
  if (octaves != 8) noise.set_octaves(static_cast<std::uint32_t>(octaves));
  const double roughness = in.values.get_float("roughness", 0.5);
  if (roughness != 0.5) noise.set_roughness(static_cast<float>(roughness));
  if (kKind != v1::NoiseTexture::MARBLE) return;
  const double scale = in.values.get_float("scale", 1), variation = in.values.get_float("variation", 0.2);
  if (scale != 1) noise.set_scale(static_cast<float>(scale));
  if (variation != 0.2) noise.set_variation(static_cast<float>(variation));
}

void refuse_ptex(const TextureInput& in, v1::Texture&) {
  in.values.parameters().ignore({"filename", "encoding", "scale"});
  in.values.diagnostics().error(in.values.parameters().where(),
                                "Ptex files are not supported: bake the texture to an image over (u, v)");
}

struct TextureType {
  std::string_view name;
  TextureWriter write;
};

constexpr TextureType kTextureTypes[] = {{"imagemap", write_imagemap},
                                         {"constant", write_constant},
                                         {"scale", write_scale},
                                         {"mix", write_mix},
                                         {"checkerboard", write_checkerboard},
                                         {"directionmix", write_direction_mix},
                                         {"dots", write_dots},
                                         {"bilerp", write_bilerp},
                                         {"fbm", write_noise<v1::NoiseTexture::FBM>},
                                         {"wrinkled", write_noise<v1::NoiseTexture::WRINKLED>},
                                         {"windy", write_noise<v1::NoiseTexture::WINDY>},
                                         {"marble", write_noise<v1::NoiseTexture::MARBLE>},
                                         {"ptex", refuse_ptex}};

}  // namespace

TextureWriter find_texture_writer(std::string_view type) {
  for (const TextureType& known : kTextureTypes) {
    if (known.name == type) return known.write;
  }
  return nullptr;
}

std::string names_of_texture_types() {
  std::string names;
  for (const TextureType& known : kTextureTypes) names += concat(names.empty() ? "" : ", ", known.name);
  return names;
}

}  // namespace tessera::client::pbrt
