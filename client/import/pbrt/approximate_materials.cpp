// Materials that Tessera does not have yet, as the nearest that it has. Each says so.
#include <algorithm>
#include <cmath>

#include "import/pbrt/material_writers.h"

#include "import/input/concat.h"

namespace tessera::client::pbrt {
namespace {

void warn_of_approximation(ValueReader& values, std::string_view instead) {
  values.warn(concat("the ", values.parameters().owner(), " is not supported yet: ", instead));
}

/// RGB of a spectrum parameter, if it is one given as RGB.
std::optional<std::array<double, 3>> rgb_of(ValueReader& values, std::string_view name, SpectrumUse use) {
  const v1::Spectrum value = values.plain_spectrum(name, 0, use);
  if (!value.has_rgb()) return std::nullopt;
  return std::array<double, 3>{value.rgb().r(), value.rgb().g(), value.rgb().b()};
}

}  // namespace

void write_coated_conductor(ValueReader& values, const UseMaterial&, v1::Material& material) {
  warn_of_approximation(values, "its conductor without the coat is used");
  v1::ConductorMaterial& conductor = *material.mutable_conductor();
  if (values.parameters().has("reflectance")) {
    *conductor.mutable_reflectance() = values.spectrum("reflectance", 1, SpectrumUse::kReflectance);
  } else {
    write_conductor_index(values, "conductor.", conductor);
  }
  write_roughness(values, "conductor.", *conductor.mutable_roughness());
  values.parameters().ignore({"interface.roughness", "interface.uroughness", "interface.vroughness", "interface.eta",
                              "thickness", "g", "albedo", "maxdepth", "nsamples"});
}

void write_hair(ValueReader& values, const UseMaterial&, v1::Material& material) {
  warn_of_approximation(values, "a diffuse material of the hair's colour is used");
  const double beta = values.get_float("beta_n", 0.3);
  values.parameters().ignore({"beta_m", "alpha", "eta"});
  v1::SpectrumValue& reflectance = *material.mutable_diffuse()->mutable_reflectance();
  for (const char* name : {"reflectance", "color"}) {
    if (!values.parameters().has(name)) continue;
    reflectance = values.spectrum(name, 0.5, SpectrumUse::kReflectance);
    return;
  }
  // Absorption of the two pigments [d'Eon et al. 2011], and the albedo of many hairs of that absorption [Chiang et al.
  // 2016, equation 9].
  std::array<double, 3> sigma_a;
  if (const auto given = rgb_of(values, "sigma_a", SpectrumUse::kUnbounded);
      given && values.parameters().has("sigma_a")) {
    sigma_a = *given;
  } else {
    const bool has_pigment = values.parameters().has("eumelanin") || values.parameters().has("pheomelanin");
    const double eumelanin = constant_of(values, "eumelanin", has_pigment ? 0 : 1.3);
    const double pheomelanin = constant_of(values, "pheomelanin", 0);
    constexpr double kEumelanin[] = {0.419, 0.697, 1.37};
    constexpr double kPheomelanin[] = {0.187, 0.4, 1.05};
    for (int c = 0; c < 3; ++c) sigma_a[c] = eumelanin * kEumelanin[c] + pheomelanin * kPheomelanin[c];
  }
  const double spread = 5.969 - 0.215 * beta + 2.532 * std::pow(beta, 2) - 10.73 * std::pow(beta, 3) +
                        5.574 * std::pow(beta, 4) + 0.245 * std::pow(beta, 5);
  std::array<double, 3> albedo;
  for (int c = 0; c < 3; ++c) albedo[c] = std::exp(-std::sqrt(sigma_a[c]) * spread);
  *reflectance.mutable_constant() = rgb_spectrum(albedo);
}

void write_measured(ValueReader& values, const UseMaterial&, v1::Material& material) {
  warn_of_approximation(values, "a diffuse material of reflectance 0.5 is used");
  values.parameters().ignore({"filename"});
  *material.mutable_diffuse()->mutable_reflectance()->mutable_constant() = constant_spectrum(0.5);
}

void write_subsurface(ValueReader& values, const UseMaterial&, v1::Material& material) {
  warn_of_approximation(values, "a coated diffuse material of its colour is used");
  v1::CoatedDiffuseMaterial& coated = *material.mutable_coated_diffuse();
  *coated.mutable_eta() = constant_spectrum(values.get_float("eta", 1.33));
  write_roughness(values, "", *coated.mutable_roughness());
  v1::SpectrumValue& reflectance = *coated.mutable_reflectance();
  const double g = values.get_float("g", 0);
  if (values.parameters().has("reflectance")) {
    reflectance = values.spectrum("reflectance", 0.5, SpectrumUse::kReflectance);
  } else if (values.parameters().has("name")) {
    *reflectance.mutable_constant() = constant_spectrum(0.5);
  } else {
    // Albedo of a half-space that scatters and absorbs [van de Hulst 1980].
    const std::array<double, 3> absorbed =
        rgb_of(values, "sigma_a", SpectrumUse::kUnbounded).value_or(std::array<double, 3>{.0011, .0024, .014});
    const std::array<double, 3> scattered =
        rgb_of(values, "sigma_s", SpectrumUse::kUnbounded).value_or(std::array<double, 3>{2.55, 3.21, 3.77});
    std::array<double, 3> albedo;
    for (int c = 0; c < 3; ++c) {
      const double extinct = absorbed[c] + scattered[c];
      const double single = extinct > 0 ? scattered[c] / extinct : 0;
      const double s = std::sqrt((1 - single) / std::max(1 - single * g, 1e-6));
      albedo[c] = std::clamp((1 - s) * (1 - 0.139 * s) / (1 + 1.17 * s), 0.0, 1.0);
    }
    *reflectance.mutable_constant() = rgb_spectrum(albedo);
  }
  values.parameters().ignore({"name", "sigma_a", "sigma_s", "mfp", "scale"});
}

}  // namespace tessera::client::pbrt
