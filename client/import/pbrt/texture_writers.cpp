#include "import/pbrt/texture_writers.h"

#include <cmath>

#include "import/input/concat.h"
#include "import/pbrt/tokenizer.h"

namespace tessera::client::pbrt {
namespace {

/// A value of the texture's own kind: a float texture's values are floats (or float textures), as spectra.
v1::SpectrumValue value_of_kind(TextureKind kind, ValueReader& values, std::string_view name, double fallback) {
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

void write_mapping(ValueReader& values, v1::UvMapping& mapping) {
  const std::string type = values.get_string("mapping", "uv");
  if (type != "uv") {
    values.warn(concat("texture mapping \"", type, "\" is not supported yet: the surface's own (u, v) are used"));
    values.parameters().ignore({"v1", "v2"});
  }
  const double scale_u = values.get_float("uscale", 1), scale_v = values.get_float("vscale", 1);
  if (scale_u != 1) mapping.set_scale_u(static_cast<float>(scale_u));
  if (scale_v != 1) mapping.set_scale_v(static_cast<float>(scale_v));
  mapping.set_offset_u(static_cast<float>(values.get_float("udelta", 0)));
  mapping.set_offset_v(static_cast<float>(values.get_float("vdelta", 0)));
}

void write_encoding(ValueReader& values, v1::ImageTexture& image) {
  const std::string encoding = values.get_string("encoding", "");
  if (encoding.empty()) return;  // AUTO is pbrt's default too
  if (encoding == "linear") {
    image.set_encoding(v1::ImageTexture::LINEAR);
  } else if (encoding == "sRGB") {
    image.set_encoding(v1::ImageTexture::SRGB);
  } else if (const auto gamma = encoding.starts_with("gamma ") ? parse_number(encoding.substr(6)) : std::nullopt) {
    image.set_encoding(v1::ImageTexture::GAMMA);
    image.set_gamma(static_cast<float>(*gamma));
  } else {
    values.diagnostics().error(values.parameters().where(),
                               concat("unknown encoding \"", encoding, "\": expected sRGB, linear or \"gamma N\""));
  }
}

void write_imagemap(TextureKind, ValueReader& values, v1::Texture& texture) {
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

  // Every sample looks the image up at full resolution: what pbrt's "trilinear" and "EWA" filter beforehand is
  // averaged by the pixel's own samples.
  const std::string filter = values.get_string("filter", "bilinear");
  if (filter == "point") {
    image.set_filter(v1::ImageTexture::NEAREST);
  } else if (filter != "bilinear" && filter != "trilinear" && filter != "EWA" && filter != "ewa") {
    values.warn(concat("texture filter \"", filter, "\" is not known: bilinear is used"));
  }
  values.parameters().ignore({"maxanisotropy"});

  const double scale = values.get_float("scale", 1);
  if (scale != 1) image.set_scale(static_cast<float>(scale));
  image.set_invert(values.get_bool("invert", false));
  write_mapping(values, *image.mutable_mapping());
}

void write_constant(TextureKind kind, ValueReader& values, v1::Texture& texture) {
  *texture.mutable_constant() = kind == TextureKind::kSpectrum
                                    ? values.plain_spectrum("value", 1, SpectrumUse::kUnbounded)
                                    : constant_spectrum(values.get_float("value", 1));
}

void write_scale(TextureKind kind, ValueReader& values, v1::Texture& texture) {
  *texture.mutable_scale()->mutable_value() = value_of_kind(kind, values, "tex", 1);
  *texture.mutable_scale()->mutable_factor() = value_of_kind(TextureKind::kFloat, values, "scale", 1);
}

void write_mix(TextureKind kind, ValueReader& values, v1::Texture& texture) {
  *texture.mutable_mix()->mutable_a() = value_of_kind(kind, values, "tex1", 0);
  *texture.mutable_mix()->mutable_b() = value_of_kind(kind, values, "tex2", 1);
  *texture.mutable_mix()->mutable_amount() = values.number("amount", 0.5);
}

void write_checkerboard(TextureKind kind, ValueReader& values, v1::Texture& texture) {
  v1::CheckerboardTexture& board = *texture.mutable_checkerboard();
  *board.mutable_even() = value_of_kind(kind, values, "tex1", 1);
  *board.mutable_odd() = value_of_kind(kind, values, "tex2", 0);
  if (values.get_integer("dimension", 2) != 2) {
    values.warn("a three-dimensional checkerboard is not supported yet: one over (u, v) is used");
  }
  write_mapping(values, *board.mutable_mapping());
}

// ---- approximations: each says so

void warn_of_approximation(ValueReader& values, std::string_view type, std::string_view instead) {
  values.warn(concat("texture type \"", type, "\" is not supported yet: ", instead));
}

void write_direction_mix(TextureKind kind, ValueReader& values, v1::Texture& texture) {
  warn_of_approximation(values, "directionmix", "an even mix of its two textures is used");
  values.parameters().ignore({"dir"});
  *texture.mutable_mix()->mutable_a() = value_of_kind(kind, values, "tex1", 0);
  *texture.mutable_mix()->mutable_b() = value_of_kind(kind, values, "tex2", 1);
  texture.mutable_mix()->mutable_amount()->set_constant(0.5f);
}

void write_dots(TextureKind kind, ValueReader& values, v1::Texture& texture) {
  // Half of the cells hold a dot of radius 0.35.
  warn_of_approximation(values, "dots", "the mean of inside and outside is used");
  v1::UvMapping unused;
  write_mapping(values, unused);
  *texture.mutable_mix()->mutable_a() = value_of_kind(kind, values, "outside", 0);
  *texture.mutable_mix()->mutable_b() = value_of_kind(kind, values, "inside", 1);
  texture.mutable_mix()->mutable_amount()->set_constant(0.19f);
}

void write_bilerp(TextureKind kind, ValueReader& values, v1::Texture& texture) {
  warn_of_approximation(values, "bilerp", "the mean of its four corners is used");
  v1::UvMapping unused;
  write_mapping(values, unused);
  double mean[3] = {0, 0, 0};
  for (const auto& [corner, fallback] : {std::pair{"v00", 0.0}, {"v01", 1.0}, {"v10", 0.0}, {"v11", 1.0}}) {
    const v1::Spectrum value = kind == TextureKind::kSpectrum
                                   ? values.plain_spectrum(corner, fallback, SpectrumUse::kUnbounded)
                                   : constant_spectrum(values.get_float(corner, fallback));
    const bool is_rgb = value.has_rgb();
    mean[0] += 0.25 * (is_rgb ? value.rgb().r() : value.constant());
    mean[1] += 0.25 * (is_rgb ? value.rgb().g() : value.constant());
    mean[2] += 0.25 * (is_rgb ? value.rgb().b() : value.constant());
  }
  *texture.mutable_constant() = rgb_spectrum({mean[0], mean[1], mean[2]});
}

template <int kPercent>
void write_noise(TextureKind, ValueReader& values, v1::Texture& texture) {
  const double mean = kPercent / 100.0;
  values.warn(concat("the ", values.parameters().owner(), " is not supported yet: the constant ", mean, " is used"));
  values.parameters().ignore({"octaves", "roughness", "scale", "variation", "filename", "encoding"});
  *texture.mutable_constant() = constant_spectrum(mean);
}

struct TextureType {
  std::string_view name;
  TextureWriter write;
};

// The means of the noises are those of their usual parameters.
constexpr TextureType kTypes[] = {{"imagemap", write_imagemap},
                                  {"constant", write_constant},
                                  {"scale", write_scale},
                                  {"mix", write_mix},
                                  {"checkerboard", write_checkerboard},
                                  {"directionmix", write_direction_mix},
                                  {"dots", write_dots},
                                  {"bilerp", write_bilerp},
                                  {"fbm", write_noise<0>},
                                  {"wrinkled", write_noise<50>},
                                  {"windy", write_noise<25>},
                                  {"marble", write_noise<80>},
                                  {"ptex", write_noise<50>}};

}  // namespace

TextureWriter find_texture_writer(std::string_view type) {
  for (const TextureType& known : kTypes) {
    if (known.name == type) return known.write;
  }
  return nullptr;
}

std::string names_of_texture_types() {
  std::string names;
  for (const TextureType& known : kTypes) names += concat(names.empty() ? "" : ", ", known.name);
  return names;
}

}  // namespace tessera::client::pbrt
