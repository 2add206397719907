#include "import/pbrt/matter/material_writers.h"

#include "import/input/concat.h"

namespace tessera::client::pbrt {
namespace {

void write_diffuse(ValueReader& values, const UseMaterial&, v1::Material& material) {
  *material.mutable_diffuse()->mutable_reflectance() =
      values.spectrum("reflectance", 0.5, SpectrumUse::kReflectance);
}

/// Reflectance, or eta and k behind `index_prefix`.
void write_conductor_color(ValueReader& values, std::string_view index_prefix,
                           v1::ConductorMaterial& conductor) {
  ParameterList& parameters = values.parameters();
  if (!parameters.has("reflectance")) return write_conductor_index(values, index_prefix, conductor);
  const std::string eta = concat(index_prefix, "eta"), k = concat(index_prefix, "k");
  if (parameters.has(eta) || parameters.has(k)) {
    values.diagnostics().error(
        parameters.where(),
        concat(parameters.owner(), ": expected either \"reflectance\" or \"", eta, "\" and \"", k, "\""));
  }
  *conductor.mutable_reflectance() = values.spectrum("reflectance", 1, SpectrumUse::kReflectance);
}

void write_conductor(ValueReader& values, const UseMaterial&, v1::Material& material) {
  write_conductor_color(values, "", *material.mutable_conductor());
  write_roughness(values, "", *material.mutable_conductor()->mutable_roughness());
}

void write_dielectric(ValueReader& values, const UseMaterial&, v1::Material& material) {
  *material.mutable_dielectric()->mutable_eta() = values.plain_spectrum("eta", 1.5, SpectrumUse::kUnbounded);
  write_roughness(values, "", *material.mutable_dielectric()->mutable_roughness());
}

void write_thin_dielectric(ValueReader& values, const UseMaterial&, v1::Material& material) {
  *material.mutable_thin_dielectric()->mutable_eta() =
      values.plain_spectrum("eta", 1.5, SpectrumUse::kUnbounded);
}

/// The medium between coat and base, of either kind of coat.
template <typename Coat>
void write_layer(ValueReader& values, Coat& coat) {
  coat.set_thickness(constant_of(values, "thickness", 0.01));
  if (values.parameters().has("albedo")) {
    *coat.mutable_albedo() = values.spectrum("albedo", 0, SpectrumUse::kReflectance);
  }
  coat.set_g(constant_of(values, "g", 0));
  values.parameters().ignore({"maxdepth", "nsamples"});  // settings of pbrt's random walk
}

void write_coated_diffuse(ValueReader& values, const UseMaterial&, v1::Material& material) {
  v1::CoatedDiffuseMaterial& coated = *material.mutable_coated_diffuse();
  *coated.mutable_reflectance() = values.spectrum("reflectance", 0.5, SpectrumUse::kReflectance);
  *coated.mutable_eta() = values.plain_spectrum("eta", 1.5, SpectrumUse::kUnbounded);
  write_roughness(values, "", *coated.mutable_roughness());
  write_layer(values, coated);
}

void write_coated_conductor(ValueReader& values, const UseMaterial&, v1::Material& material) {
  v1::CoatedConductorMaterial& coated = *material.mutable_coated_conductor();
  write_conductor_color(values, "conductor.", *coated.mutable_conductor());
  write_roughness(values, "conductor.", *coated.mutable_conductor()->mutable_roughness());
  *coated.mutable_eta() = values.plain_spectrum("interface.eta", 1.5, SpectrumUse::kUnbounded);
  write_roughness(values, "interface.", *coated.mutable_roughness());
  write_layer(values, coated);
}

/// Absorption of the two pigments [d'Eon et al. 2011], in concentrations as Chiang et al. [2016] give them.
std::array<double, 3> absorption_of_pigments(double eumelanin, double pheomelanin) {
  constexpr double kEumelanin[] = {0.419, 0.697, 1.37};
  constexpr double kPheomelanin[] = {0.187, 0.4, 1.05};
  std::array<double, 3> sigma_a;
  for (std::size_t c = 0; c < 3; ++c) sigma_a[c] = eumelanin * kEumelanin[c] + pheomelanin * kPheomelanin[c];
  return sigma_a;
}

void write_hair(ValueReader& values, const UseMaterial&, v1::Material& material) {
  v1::HairMaterial& hair = *material.mutable_hair();
  ParameterList& parameters = values.parameters();
  // The first of these that is given counts, as in pbrt-v4; "color" is the old name of "reflectance".
  const char* color = parameters.has("reflectance") ? "reflectance" : "color";
  if (parameters.has("sigma_a")) {
    *hair.mutable_sigma_a() = values.spectrum("sigma_a", 1, SpectrumUse::kUnbounded);
  } else if (parameters.has(color)) {
    *hair.mutable_reflectance() = values.spectrum(color, 0.5, SpectrumUse::kReflectance);
  } else {
    const bool has_pigment = parameters.has("eumelanin") || parameters.has("pheomelanin");
    const double eumelanin = constant_of(values, "eumelanin", has_pigment ? 0 : 1.3);
    const double pheomelanin = constant_of(values, "pheomelanin", 0);
    *hair.mutable_sigma_a()->mutable_constant() =
        rgb_spectrum(absorption_of_pigments(eumelanin, pheomelanin));
  }
  hair.set_eta(constant_of(values, "eta", 1.55));
  *hair.mutable_beta_m() = values.number("beta_m", 0.3);
  *hair.mutable_beta_n() = values.number("beta_n", 0.3);
  hair.set_alpha_degrees(constant_of(values, "alpha", 2));
}

void write_diffuse_transmission(ValueReader& values, const UseMaterial&, v1::Material& material) {
  v1::DiffuseTransmissionMaterial& sheet = *material.mutable_diffuse_transmission();
  *sheet.mutable_reflectance() = values.spectrum("reflectance", 0.25, SpectrumUse::kReflectance);
  *sheet.mutable_transmittance() = values.spectrum("transmittance", 0.25, SpectrumUse::kReflectance);
  const double scale = values.get_float("scale", 1);
  if (scale != 1) sheet.set_scale(static_cast<float>(scale));
}

/// Not pbrt's own: for scenes of textbooks.
void write_phong(ValueReader& values, const UseMaterial&, v1::Material& material) {
  v1::PhongMaterial& phong = *material.mutable_phong();
  *phong.mutable_diffuse() = values.spectrum("diffuse", 0.5, SpectrumUse::kReflectance);
  *phong.mutable_specular() = values.spectrum("specular", 0.2, SpectrumUse::kReflectance);
  *phong.mutable_exponent() = values.number("exponent", 30);
  const std::string lobe = values.get_string("lobe", "phong");
  if (lobe == "blinn") phong.set_lobe(v1::PhongMaterial::BLINN);
  if (lobe == "mirror") phong.set_lobe(v1::PhongMaterial::MIRROR);
  if (lobe != "phong" && lobe != "blinn" && lobe != "mirror") {
    values.diagnostics().error(values.parameters().where(),
                               concat(values.parameters().owner(), ": unknown \"lobe\" \"", lobe,
                                      "\": expected phong, blinn or mirror"));
  }
}

void write_mix(ValueReader& values, const UseMaterial& use, v1::Material& material) {
  const Parameter* names =
      values.parameters().find("materials", {ParameterType::kString}, values.diagnostics());
  if (names == nullptr || names->strings.size() != 2) {
    values.diagnostics().error(
        values.parameters().where(),
        concat(values.parameters().owner(), ": expected \"string materials\" with two names"));
    return;
  }
  v1::MixMaterial& mix = *material.mutable_mix();
  mix.set_a(use(names->strings[0], names->where));
  mix.set_b(use(names->strings[1], names->where));
  *mix.mutable_amount() = values.number("amount", 0.5);
}

void write_interface(ValueReader&, const UseMaterial&, v1::Material& material) {
  material.mutable_interface();
}

struct MaterialType {
  std::string_view name;
  MaterialWriter write;
};

constexpr MaterialType kMaterialTypes[] = {{"diffuse", write_diffuse},
                                           {"coateddiffuse", write_coated_diffuse},
                                           {"conductor", write_conductor},
                                           {"coatedconductor", write_coated_conductor},
                                           {"dielectric", write_dielectric},
                                           {"thindielectric", write_thin_dielectric},
                                           {"diffusetransmission", write_diffuse_transmission},
                                           {"hair", write_hair},
                                           {"phong", write_phong},
                                           {"measured", write_measured},
                                           {"subsurface", write_subsurface},
                                           {"mix", write_mix},
                                           {"interface", write_interface},
                                           {"", write_interface},
                                           {"none", write_interface}};

}  // namespace

MaterialWriter find_material_writer(std::string_view type) {
  for (const MaterialType& known : kMaterialTypes) {
    if (known.name == type) return known.write;
  }
  return nullptr;
}

std::string names_of_material_types() {
  std::string names;
  for (const MaterialType& known : kMaterialTypes) {
    if (!known.name.empty() && known.name != "none") names += concat(names.empty() ? "" : ", ", known.name);
  }
  return names;
}

void write_roughness(ValueReader& values, std::string_view prefix, v1::Roughness& roughness) {
  const std::string both = concat(prefix, "roughness");
  for (const auto& [axis, target] :
       {std::pair{"uroughness", roughness.mutable_u()}, {"vroughness", roughness.mutable_v()}}) {
    const std::string own = concat(prefix, axis);
    *target = values.number(values.parameters().has(own) ? own : both, 0);
  }
  roughness.set_remap(values.get_bool("remaproughness", true));
  roughness.set_multiple_scattering(false);
  values.parameters().ignore({both});  // beside both of the others it has no effect
}

void write_conductor_index(ValueReader& values, std::string_view prefix, v1::ConductorMaterial& conductor) {
  // Copper, where the file says nothing.
  const auto index = [&](std::string_view name, const char* fallback) {
    const std::string full = concat(prefix, name);
    if (values.parameters().has(full)) return values.spectrum(full, 1, SpectrumUse::kUnbounded);
    Parameter copper;
    copper.type = ParameterType::kSpectrum;
    copper.name = full;
    copper.strings = {fallback};
    v1::SpectrumValue value;
    *value.mutable_constant() =
        *read_spectrum(values.context(), copper, values.parameters().owner(), SpectrumUse::kUnbounded);
    return value;
  };
  *conductor.mutable_eta() = index("eta", "metal-Cu-eta");
  *conductor.mutable_k() = index("k", "metal-Cu-k");
}

float constant_of(ValueReader& values, std::string_view name, double fallback) {
  const v1::FloatValue value = values.number(name, fallback);
  if (value.kind_case() != v1::FloatValue::kTexture) return value.constant();
  values.warn(concat("a texture for \"", name, "\" of ", values.parameters().owner(),
                     " is not supported yet: ", fallback, " is used"));
  return static_cast<float>(fallback);
}

}  // namespace tessera::client::pbrt
