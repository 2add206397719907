// Materials that Tessera does not have yet, as the nearest that it has. Each says so.
#include <algorithm>
#include <cmath>

#include "import/pbrt/matter/material_writers.h"

#include "import/input/concat.h"

namespace tessera::client::pbrt {
namespace {

void warn_of_approximation(ValueReader& values, std::string_view instead) {
  values.warn(concat("the ", values.parameters().owner(), " is not supported yet: ", instead));
}

/// RGB of a spectrum parameter, if it is given.
std::optional<std::array<double, 3>> rgb_of(ValueReader& values, std::string_view name, SpectrumUse use) {
  if (!values.parameters().has(name)) return std::nullopt;
  return linear_rgb_of(values.plain_spectrum(name, 0, use));
}

}  // namespace

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
    const std::array<double, 3> absorbed = rgb_of(values, "sigma_a", SpectrumUse::kUnbounded)
                                               .value_or(std::array<double, 3>{.0011, .0024, .014});
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
