#include "import/mitsuba/matter/bsdf_writers.h"

#include <algorithm>

#include "base/nearest_name.h"
#include "import/input/concat.h"
#include "import/mitsuba/matter/ior.h"
#include "spectra/matter/metal_colors.h"
#include "spectra/named_spectra.h"
#include "spectra/rgb/mitsuba_rgb.h"

namespace tessera::client::mitsuba {
namespace {

/// A colour that only matters when it is given.
void write_tint(PropertyReader& reader, SceneTextures& textures, std::string_view name,
                v1::SpectrumValue* tint) {
  *tint = textures.color(reader, name, 1, ColorUse::kReflectance);
}

void write_distribution(PropertyReader& reader, v1::Roughness& roughness) {
  roughness.set_separable_masking(true);
  roughness.set_multiple_scattering(false);
  const std::string distribution = reader.keyword("distribution", "beckmann");
  if (distribution == "beckmann") {
    roughness.set_distribution(v1::Roughness::BECKMANN);
  } else if (distribution == "ggx") {
    roughness.set_distribution(v1::Roughness::GGX);
  } else {
    reader.error(*reader.find("distribution"),
                 concat("expected beckmann or ggx, found \"", distribution, "\""));
  }
  // How samples are drawn does not change what they converge to.
  reader.ignore({"sample_visible"});
}

void write_roughness(PropertyReader& reader, SceneTextures& textures, v1::Roughness& roughness) {
  write_distribution(reader, roughness);
  const bool anisotropic = reader.has("alpha_u") || reader.has("alpha_v");
  if (anisotropic && (!reader.has("alpha_u") || !reader.has("alpha_v") || reader.has("alpha"))) {
    reader.error(concat(reader.object().title(), ": expected either alpha, or both alpha_u and alpha_v"));
  }
  *roughness.mutable_u() = textures.scalar(reader, anisotropic ? "alpha_u" : "alpha", 0.1);
  *roughness.mutable_v() = anisotropic ? textures.scalar(reader, "alpha_v", 0.1) : roughness.u();
}

void write_diffuse(PropertyReader& reader, SceneTextures& textures, v1::Material& material) {
  *material.mutable_diffuse()->mutable_reflectance() =
      textures.color(reader, "reflectance", 0.5, ColorUse::kReflectance);
}

void write_smooth_dielectric(PropertyReader& reader, SceneTextures& textures, v1::Material& material) {
  v1::DielectricMaterial& dielectric = *material.mutable_dielectric();
  *dielectric.mutable_eta() = constant_spectrum(read_relative_ior(reader, "bk7"));
  if (reader.has("specular_reflectance")) {
    write_tint(reader, textures, "specular_reflectance", dielectric.mutable_reflection_tint());
  }
  if (reader.has("specular_transmittance")) {
    write_tint(reader, textures, "specular_transmittance", dielectric.mutable_transmission_tint());
  }
}

void write_rough_dielectric(PropertyReader& reader, SceneTextures& textures, v1::Material& material) {
  write_smooth_dielectric(reader, textures, material);
  write_roughness(reader, textures, *material.mutable_dielectric()->mutable_roughness());
}

void write_thin_dielectric(PropertyReader& reader, SceneTextures& textures, v1::Material& material) {
  v1::ThinDielectricMaterial& thin = *material.mutable_thin_dielectric();
  *thin.mutable_eta() = constant_spectrum(read_relative_ior(reader, "bk7"));
  thin.set_passes_straight(true);
  if (reader.has("specular_reflectance")) {
    write_tint(reader, textures, "specular_reflectance", thin.mutable_reflection_tint());
  }
  if (reader.has("specular_transmittance")) {
    write_tint(reader, textures, "specular_transmittance", thin.mutable_transmission_tint());
  }
}

/// An index of a measured metal, whose colour is that without a light to see it in.
std::optional<ConstantColor> metal_index(const std::string& metal, std::string_view index) {
  if (auto curve = spectra::find_named_spectrum(concat("metal-", metal, "-", index))) {
    ConstantColor color{spectra::mitsuba_rgb(*curve, spectra::SeenUnder::kEqualEnergy)};
    for (double& component : color.rgb) component = std::max(component, 0.0);
    color.curve = *std::move(curve);
    return color;
  }
  const std::optional<spectra::MetalColor> known = spectra::find_metal_color(metal);
  if (!known) return std::nullopt;
  return ConstantColor{index == "eta" ? known->eta : known->k};
}

void write_conductor(PropertyReader& reader, SceneTextures& textures, v1::Material& material) {
  v1::ConductorMaterial& conductor = *material.mutable_conductor();
  const std::string metal = reader.text("material", "none");
  if (metal == "none") {
    *conductor.mutable_eta() = textures.color(reader, "eta", 0, ColorUse::kUnbounded);
    *conductor.mutable_k() = textures.color(reader, "k", 1, ColorUse::kUnbounded);
  } else {
    if (reader.has("eta") || reader.has("k")) {
      reader.error(concat(reader.object().title(), ": expected either \"material\", or \"eta\" and \"k\""));
    }
    if (const std::optional<ConstantColor> eta = metal_index(metal, "eta")) {
      *conductor.mutable_eta()->mutable_constant() = eta->to_spectrum();
      *conductor.mutable_k()->mutable_constant() = metal_index(metal, "k")->to_spectrum();
    } else {
      std::vector<std::string> known = spectra::metal_color_names();
      known.insert(known.begin(), {"Ag", "Al", "Au", "Cu", "CuZn", "MgO", "TiO2"});
      std::string names;
      for (const std::string& name : known) names += concat(name, ", ");
      reader.error(*reader.find("material"), concat("there are no measurements of \"", metal, "\" here",
                                                    base::did_you_mean(metal, known), ": expected ", names,
                                                    "or none, or \"eta\" and \"k\""));
    }
  }
  if (reader.has("specular_reflectance")) {
    write_tint(reader, textures, "specular_reflectance", conductor.mutable_tint());
  }
}

void write_rough_conductor(PropertyReader& reader, SceneTextures& textures, v1::Material& material) {
  write_conductor(reader, textures, material);
  write_roughness(reader, textures, *material.mutable_conductor()->mutable_roughness());
}

void write_plastic(PropertyReader& reader, SceneTextures& textures, v1::Material& material) {
  v1::PlasticMaterial& plastic = *material.mutable_plastic();
  *plastic.mutable_reflectance() = textures.color(reader, "diffuse_reflectance", 0.5, ColorUse::kReflectance);
  *plastic.mutable_eta() = constant_spectrum(read_relative_ior(reader, "polypropylene"));
  plastic.set_nonlinear(reader.boolean("nonlinear", false));
  if (reader.has("specular_reflectance")) {
    write_tint(reader, textures, "specular_reflectance", plastic.mutable_tint());
  }
}

void write_rough_plastic(PropertyReader& reader, SceneTextures& textures, v1::Material& material) {
  write_plastic(reader, textures, material);
  v1::Roughness& roughness = *material.mutable_plastic()->mutable_roughness();
  write_distribution(reader, roughness);
  const float alpha = static_cast<float>(reader.number("alpha", 0.1));
  roughness.mutable_u()->set_constant(alpha);
  roughness.mutable_v()->set_constant(alpha);
}

/// Writes "phong", which Mitsuba 0.6 has; names and defaults are that version's.
void write_phong(PropertyReader& reader, SceneTextures& textures, v1::Material& material) {
  v1::PhongMaterial& phong = *material.mutable_phong();
  *phong.mutable_diffuse() = textures.color(reader, "diffuse_reflectance", 0.5, ColorUse::kReflectance);
  *phong.mutable_specular() = textures.color(reader, "specular_reflectance", 0.2, ColorUse::kReflectance);
  *phong.mutable_exponent() = textures.scalar(reader, "exponent", 30);
}

/// Writes what "principled" and "principledthin" have in common.
void write_burley(PropertyReader& reader, SceneTextures& textures, v1::PrincipledMaterial& principled) {
  *principled.mutable_base_color() = textures.color(reader, "base_color", 0.5, ColorUse::kReflectance);
  const auto write = [&](std::string_view name, double fallback, v1::FloatValue* value) {
    *value = textures.scalar(reader, name, fallback);
  };
  write("roughness", 0.5, principled.mutable_roughness());
  write("anisotropic", 0, principled.mutable_anisotropic());
  write("spec_trans", 0, principled.mutable_spec_trans());
  write("spec_tint", 0, principled.mutable_spec_tint());
  write("sheen", 0, principled.mutable_sheen());
  write("sheen_tint", 0, principled.mutable_sheen_tint());
  write("flatness", 0, principled.mutable_flatness());
  reader.ignore({"main_specular_sampling_rate", "clearcoat_sampling_rate",
                 "diffuse_reflectance_sampling_rate", "spec_reflect_sampling_rate",
                 "spec_trans_sampling_rate", "diff_trans_sampling_rate"});
}

void write_principled(PropertyReader& reader, SceneTextures& textures, v1::Material& material) {
  v1::PrincipledMaterial& principled = *material.mutable_principled();
  write_burley(reader, textures, principled);
  *principled.mutable_metallic() = textures.scalar(reader, "metallic", 0);
  *principled.mutable_clearcoat() = textures.scalar(reader, "clearcoat", 0);
  *principled.mutable_clearcoat_gloss() = textures.scalar(reader, "clearcoat_gloss", 0);
  const bool transmits = reader.has("spec_trans");
  if (reader.has("eta")) {
    if (reader.has("specular")) {
      reader.error(concat(reader.object().title(), ": \"eta\" and \"specular\" exclude each other"));
    }
    // An index of 1 does not refract: Mitsuba moves it off there.
    const double eta = reader.number("eta", 1.5);
    principled.set_eta(static_cast<float>(transmits && eta == 1 ? 1.001 : eta));
  } else {
    const double specular = reader.number("specular", 0.5);
    principled.mutable_specular()->set_constant(
        static_cast<float>(transmits && specular == 0 ? 1e-3 : specular));
  }
}

void write_principled_thin(PropertyReader& reader, SceneTextures& textures, v1::Material& material) {
  v1::PrincipledMaterial& principled = *material.mutable_principled();
  write_burley(reader, textures, principled);
  principled.set_thin(true);
  principled.set_eta(static_cast<float>(reader.number("eta", 1.5)));
  *principled.mutable_diff_trans() = textures.scalar(reader, "diff_trans", 0);
}

void write_null(PropertyReader&, SceneTextures&, v1::Material& material) { material.mutable_interface(); }

constexpr BsdfType kBsdfTypes[] = {{"diffuse", write_diffuse},
                                   {"dielectric", write_smooth_dielectric, true},
                                   {"thindielectric", write_thin_dielectric, true},
                                   {"roughdielectric", write_rough_dielectric, true},
                                   {"conductor", write_conductor},
                                   {"roughconductor", write_rough_conductor},
                                   {"plastic", write_plastic},
                                   {"roughplastic", write_rough_plastic},
                                   {"phong", write_phong},
                                   {"principled", write_principled},
                                   {"principledthin", write_principled_thin, true},
                                   {"null", write_null, true}};

}  // namespace

const BsdfType* find_bsdf_type(std::string_view name) {
  for (const BsdfType& type : kBsdfTypes) {
    if (type.name == name) return &type;
  }
  return nullptr;
}

std::string names_of_bsdf_types() {
  std::string names;
  for (const BsdfType& type : kBsdfTypes) names += concat(names.empty() ? "" : ", ", type.name);
  return names;
}

}  // namespace tessera::client::mitsuba
