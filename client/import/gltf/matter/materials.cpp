#include "import/gltf/matter/materials.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace tessera::client::gltf {
namespace {

using Color = std::array<double, 3>;

v1::SpectrumValue constant(const Color& color) {
  v1::SpectrumValue value;
  v1::Rgb& rgb = *value.mutable_constant()->mutable_rgb();
  rgb.set_r(static_cast<float>(color[0]));
  rgb.set_g(static_cast<float>(color[1]));
  rgb.set_b(static_cast<float>(color[2]));
  return value;
}

v1::SpectrumValue textured(const std::string& name) {
  v1::SpectrumValue value;
  value.set_texture(name);
  return value;
}

Color color_of(const Json* object, const char* name, const Color& fallback) {
  const Json* value = member(object, name);
  if (value == nullptr) return fallback;
  return {(*value)[0].get<double>(), (*value)[1].get<double>(), (*value)[2].get<double>()};
}

TextureUse texture_of(const Json* object, const std::string& place, const char* name) {
  return {member(object, name), below(place, name)};
}

/// x and y times `scale`, as glTF's normalTexture.scale has it.
void scale_normal(float (&pixel)[4], double scale) {
  float n[3] = {(2 * pixel[0] - 1) * static_cast<float>(scale),
                (2 * pixel[1] - 1) * static_cast<float>(scale), 2 * pixel[2] - 1};
  const float length = std::max(std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]), 1e-6f);
  for (int c = 0; c < 3; ++c) pixel[c] = 0.5f * n[c] / length + 0.5f;
}

void cut_alpha(float (&pixel)[4], double cutoff) { pixel[0] = pixel[3] >= cutoff ? 1.0f : 0.0f; }

}  // namespace

int MaterialTable::texture_set(std::optional<std::size_t> material) const {
  if (!material) return 0;
  const Json* json = element(&context_.document, "materials", *material);
  const Json* core = member(json, "pbrMetallicRoughness");
  for (const TextureUse& use :
       {texture_of(core, "", "baseColorTexture"), texture_of(json, "", "normalTexture"),
        texture_of(core, "", "metallicRoughnessTexture"), texture_of(json, "", "emissiveTexture")}) {
    if (use) return use.set();
  }
  return 0;
}

/// Writes one material.
struct MaterialTable::Writer {
  Context& context;
  SceneTextures& textures;
  const Vertices& vertices;
  int set;
  std::string name;

  /// Whether a texture can be looked up on these vertices.
  bool usable(const TextureUse& use) {
    if (!use) return false;
    if (!vertices.has_uvs) {
      context.warn(use.place,
                   "a texture on vertices without its TEXCOORD: left out, its factor stands alone");
      return false;
    }
    if (use.set() == set) return true;
    context.warn(use.place, concat("a texture of TEXCOORD_", use.set(), " beside those of TEXCOORD_", set,
                                   ": left out, its factor stands alone"));
    return false;
  }

  v1::FloatValue scalar(const TextureUse& use, v1::ImageTexture::Channel channel, double factor,
                        bool inverted = false) {
    v1::FloatValue value;
    value.set_constant(static_cast<float>(inverted ? 1 - factor : factor));
    if (!usable(use)) return value;
    if (std::optional<v1::ImageTexture> image = textures.image(use, false, channel)) {
      if (factor != 1) image->set_scale(static_cast<float>(factor));
      image->set_invert(inverted);
      value.set_texture(textures.add(*image, name));
    }
    return value;
  }

  v1::SpectrumValue color(const TextureUse& use, const Color& factor) {
    if (!usable(use)) return constant(factor);
    const std::optional<v1::ImageTexture> image = textures.image(use, true);
    if (!image) return constant(factor);
    return product(textured(textures.add(*image, name)), factor);
  }
  v1::SpectrumValue product(const v1::SpectrumValue& value, const Color& factor) {
    if (factor == Color{1, 1, 1}) return value;
    return textured(textures.add_product(value, constant(factor)));
  }
  v1::SpectrumValue with_vertex_color(const v1::SpectrumValue& value) {
    if (!vertices.has_color) return value;
    return textured(textures.add_product(value, textured(textures.add_attribute(kColorAttribute))));
  }

  std::optional<v1::ImageTexture> normal_map(const TextureUse& use) {
    if (!usable(use)) return std::nullopt;
    const double scale = number_of(use.info, "scale", 1);
    return scale == 1 ? textures.image(use, false)
                      : textures.changed_image(use, concat("scaled-", scale), false, scale_normal, scale);
  }

  /// Follows alphaMode. `use` has the alpha, times `factor` and that of the vertices.
  bool write_opacity(const Json* json, const std::string& place, const TextureUse& use, double factor,
                     v1::Material& material) {
    const std::string mode = text_of(json, "alphaMode", "OPAQUE");
    if (mode == "OPAQUE") return false;
    const bool has_texture = usable(use);
    if (mode == "MASK") {
      const double cutoff = number_of(json, "alphaCutoff", 0.5);
      if (vertices.has_alpha)
        context.warn(place, "the alpha of vertices does not count where alphaMode is MASK");
      if (!has_texture) {
        material.mutable_opacity()->set_constant(factor >= cutoff ? 1 : 0);
        return factor < cutoff;
      }
      const double least = factor > 0 ? cutoff / factor : 2;
      const auto image = textures.changed_image(use, concat("mask-", least), true, cut_alpha, least);
      if (image) material.mutable_opacity()->set_texture(textures.add(*image, name + "-mask"));
      return true;
    }
    *material.mutable_opacity() = scalar(use, v1::ImageTexture::ALPHA, factor);
    if (!vertices.has_alpha) return material.opacity().has_texture() || factor < 1;
    const v1::SpectrumValue own = material.opacity().has_texture() ? textured(material.opacity().texture())
                                                                   : constant({factor, factor, factor});
    material.mutable_opacity()->set_texture(
        textures.add_product(own, textured(textures.add_attribute(kAlphaAttribute))));
    return true;
  }

  void write_emission(const TextureUse& use, const Color& factor, double strength, Matter& matter) {
    if (std::ranges::max(factor) > 1)
      context.warn("", "an emissiveFactor above 1, which glTF does not allow, is taken as it is");
    if (std::ranges::max(factor) * strength <= 0) return;
    v1::AreaLight& light = matter.emission.emplace();
    *light.mutable_radiance() = constant(factor).constant();
    if (strength != 1) light.set_scale(static_cast<float>(strength));
    if (!usable(use)) return;
    if (const auto image = textures.image(use, true))
      light.set_texture(textures.add(*image, name + "-emission"));
  }

  // ---- extensions

  void write_layers(const Json* json, const std::string& place, v1::GltfMaterial& gltf, Matter& matter) {
    const auto open = [&](const char* extension_name, auto&& write) {
      if (const Json* found = extension(json, extension_name))
        write(found, below(below(place, "extensions"), extension_name));
    };
    open("KHR_materials_ior", [&](const Json* e, const std::string& at) {
      const double ior = number_of(e, "ior", 1.5);
      if (ior > 0 && ior < 1)
        context.error(below(at, "ior"), concat("an index of ", ior, ", neither 0 nor at least 1"));
      // 0 says that all light is reflected.
      gltf.set_ior(static_cast<float>(ior == 0 ? 1e4 : std::clamp(ior, 1e-3, 1e4)));
    });
    open("KHR_materials_specular", [&](const Json* e, const std::string& at) {
      *gltf.mutable_specular() = scalar(texture_of(e, at, "specularTexture"), v1::ImageTexture::ALPHA,
                                        number_of(e, "specularFactor", 1));
      *gltf.mutable_specular_color() =
          color(texture_of(e, at, "specularColorTexture"), color_of(e, "specularColorFactor", {1, 1, 1}));
    });
    open("KHR_materials_transmission", [&](const Json* e, const std::string& at) {
      *gltf.mutable_transmission() = scalar(texture_of(e, at, "transmissionTexture"), v1::ImageTexture::RED,
                                            number_of(e, "transmissionFactor", 0));
    });
    open("KHR_materials_volume", [&](const Json* e, const std::string&) { write_volume(e, gltf, matter); });
    open("KHR_materials_clearcoat", [&](const Json* e, const std::string& at) {
      *gltf.mutable_clearcoat() = scalar(texture_of(e, at, "clearcoatTexture"), v1::ImageTexture::RED,
                                         number_of(e, "clearcoatFactor", 0));
      *gltf.mutable_clearcoat_roughness() =
          scalar(texture_of(e, at, "clearcoatRoughnessTexture"), v1::ImageTexture::GREEN,
                 number_of(e, "clearcoatRoughnessFactor", 0));
      if (const auto map = normal_map(texture_of(e, at, "clearcoatNormalTexture")))
        *gltf.mutable_clearcoat_normal_map() = *map;
    });
    open("KHR_materials_sheen", [&](const Json* e, const std::string& at) {
      *gltf.mutable_sheen_color() =
          color(texture_of(e, at, "sheenColorTexture"), color_of(e, "sheenColorFactor", {0, 0, 0}));
      *gltf.mutable_sheen_roughness() =
          scalar(texture_of(e, at, "sheenRoughnessTexture"), v1::ImageTexture::ALPHA,
                 number_of(e, "sheenRoughnessFactor", 0));
    });
    open("KHR_materials_anisotropy", [&](const Json* e, const std::string& at) {
      const TextureUse directions = texture_of(e, at, "anisotropyTexture");
      *gltf.mutable_anisotropy() =
          scalar(directions, v1::ImageTexture::BLUE, number_of(e, "anisotropyStrength", 0));
      gltf.set_anisotropy_rotation(
          static_cast<float>(number_of(e, "anisotropyRotation", 0) * 180 / 3.14159265358979));
      if (!usable(directions)) return;
      if (const auto image = textures.image(directions, false))
        gltf.mutable_anisotropy_direction()->set_texture(textures.add(*image, name));
    });
    open("KHR_materials_diffuse_transmission", [&](const Json* e, const std::string& at) {
      *gltf.mutable_diffuse_transmission() =
          scalar(texture_of(e, at, "diffuseTransmissionTexture"), v1::ImageTexture::ALPHA,
                 number_of(e, "diffuseTransmissionFactor", 0));
      *gltf.mutable_diffuse_transmission_color() =
          color(texture_of(e, at, "diffuseTransmissionColorTexture"),
                color_of(e, "diffuseTransmissionColorFactor", {1, 1, 1}));
    });
    open("KHR_materials_iridescence", [&](const Json* e, const std::string& at) { write_film(e, at, gltf); });
    open("KHR_materials_dispersion", [&](const Json* e, const std::string& at) {
      const double dispersion = number_of(e, "dispersion", 0);
      if (gltf.volume()) gltf.set_dispersion(static_cast<float>(std::min(dispersion, 1e6)));
      if (dispersion > 0 && !gltf.volume())
        context.warn(at, "dispersion without a volume: nothing is refracted, so no colours part");
    });
  }

  void write_film(const Json* film, const std::string& place, v1::GltfMaterial& gltf) {
    const double factor = number_of(film, "iridescenceFactor", 0);
    if (factor <= 0) return;
    constexpr double kMostIndex = 1e4, kMostThickness = 1e6;
    *gltf.mutable_iridescence() =
        scalar(texture_of(film, place, "iridescenceTexture"), v1::ImageTexture::RED, factor);
    gltf.set_iridescence_ior(
        static_cast<float>(std::min(number_of(film, "iridescenceIor", 1.3), kMostIndex)));
    const double least = std::min(number_of(film, "iridescenceThicknessMinimum", 100), kMostThickness),
                 most = std::min(number_of(film, "iridescenceThicknessMaximum", 400), kMostThickness);
    v1::FloatValue& thickness = *gltf.mutable_iridescence_thickness();
    thickness.set_constant(static_cast<float>(most));
    const TextureUse use = texture_of(film, place, "iridescenceThicknessTexture");
    if (!usable(use)) return;
    if (const auto image = textures.image(use, false, v1::ImageTexture::GREEN))
      thickness.set_texture(textures.add_mix(constant({least, least, least}), constant({most, most, most}),
                                             textures.add(*image, name)));
  }

  void write_volume(const Json* volume, v1::GltfMaterial& gltf, Matter& matter) {
    // Without a thickness it is a sheet; how thick it is, rays find out.
    if (number_of(volume, "thicknessFactor", 0) <= 0) return;
    gltf.set_volume(true);
    const double distance = number_of(volume, "attenuationDistance", 0);
    const Color attenuation = color_of(volume, "attenuationColor", {1, 1, 1});
    if (distance <= 0 || attenuation == Color{1, 1, 1}) return;
    v1::Medium& medium = *context.scene.add_media();
    matter.medium = name + "-inside";
    medium.set_name(matter.medium);
    // The light that is left after `distance` is the colour: exp(-sigma distance). Black would be infinitely
    // dense.
    constexpr double kDarkest = 1e-4;
    Color sigma;
    for (std::size_t c = 0; c < 3; ++c)
      sigma[c] = std::min(-std::log(std::max(attenuation[c], kDarkest)) / distance, 1e6);
    *medium.mutable_extinction()->mutable_constant() = constant(sigma).constant();
    *medium.mutable_albedo()->mutable_constant() = constant({0, 0, 0}).constant();
  }

  /// The archived model: F0 and the base in two colours, which the layers have too.
  void write_specular_glossiness(const Json* e, const std::string& at, v1::GltfMaterial& gltf) {
    constexpr double kDielectric = 0.04;
    Color specular = color_of(e, "specularFactor", {1, 1, 1});
    for (double& c : specular) c /= kDielectric;
    const TextureUse both = texture_of(e, at, "specularGlossinessTexture");
    gltf.mutable_metallic()->set_constant(0);
    *gltf.mutable_specular_color() = color(both, specular);
    *gltf.mutable_roughness() =
        scalar(both, v1::ImageTexture::ALPHA, number_of(e, "glossinessFactor", 1), true);
  }
};

Matter MaterialTable::write(std::optional<std::size_t> index, const Vertices& vertices) {
  static const Json kNone = Json::object();
  const Json* json = index ? element(&context_.document, "materials", *index) : &kNone;
  const std::string place = index ? below("/materials", *index) : "/materials";
  std::string stem = text_of(json, "name", index ? concat("material-", *index) : "default");
  if (stem.empty()) stem = concat("material-", *index);
  const std::string name = names_.unique(stem);
  Matter matter;
  matter.material = name;
  v1::Material material;
  material.set_name(name);
  Writer writer{context_, textures_, vertices, texture_set(index), name};
  constexpr const char* kGlossiness = "KHR_materials_pbrSpecularGlossiness";
  const Json* glossiness = extension(json, kGlossiness);
  const Json* core = glossiness != nullptr ? glossiness : member(json, "pbrMetallicRoughness");
  const std::string at = glossiness != nullptr ? below(below(place, "extensions"), kGlossiness)
                                               : below(place, "pbrMetallicRoughness");
  const char* const factor_name = glossiness != nullptr ? "diffuseFactor" : "baseColorFactor";
  const TextureUse base = texture_of(core, at, glossiness != nullptr ? "diffuseTexture" : "baseColorTexture");
  const Json* base_factor = member(core, factor_name);
  const double alpha = base_factor == nullptr ? 1 : (*base_factor)[3].get<double>();
  matter.passes = writer.write_opacity(json, place, base, alpha, material);

  const v1::SpectrumValue color =
      writer.with_vertex_color(writer.color(base, color_of(core, factor_name, {1, 1, 1})));
  if (extension(json, "KHR_materials_unlit") != nullptr) {
    // It shows its colour whatever the light: it emits that, and reflects nothing.
    *material.mutable_diffuse()->mutable_reflectance() = constant({0, 0, 0});
    v1::AreaLight& light = matter.emission.emplace();
    light.set_two_sided(true);
    if (color.has_texture()) {
      *light.mutable_radiance() = constant({1, 1, 1}).constant();
      light.set_texture(color.texture());
    } else {
      *light.mutable_radiance() = color.constant();
    }
  } else {
    v1::GltfMaterial& gltf = *material.mutable_gltf();
    *gltf.mutable_base_color() = color;
    const TextureUse parts = texture_of(core, at, "metallicRoughnessTexture");
    *gltf.mutable_metallic() =
        writer.scalar(parts, v1::ImageTexture::BLUE, number_of(core, "metallicFactor", 1));
    *gltf.mutable_roughness() =
        writer.scalar(parts, v1::ImageTexture::GREEN, number_of(core, "roughnessFactor", 1));
    if (glossiness != nullptr) writer.write_specular_glossiness(glossiness, at, gltf);
    writer.write_layers(json, place, gltf, matter);
    if (const auto map = writer.normal_map(texture_of(json, place, "normalTexture")))
      *material.mutable_normal_map() = *map;
    writer.write_emission(
        texture_of(json, place, "emissiveTexture"), color_of(json, "emissiveFactor", {0, 0, 0}),
        number_of(extension(json, "KHR_materials_emissive_strength"), "emissiveStrength", 1), matter);
    if (matter.emission) matter.emission->set_two_sided(flag_of(json, "doubleSided", false));
  }
  *context_.scene.add_materials() = std::move(material);
  return matter;
}

const Matter& MaterialTable::use(std::optional<std::size_t> material, const Vertices& vertices) {
  const Key key{material, vertices.has_uvs, vertices.has_color, vertices.has_alpha};
  const auto known = known_.find(key);
  return known != known_.end() ? known->second : known_.emplace(key, write(material, vertices)).first->second;
}

}  // namespace tessera::client::gltf
