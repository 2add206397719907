// Complex indices of refraction of metals and of some oxides, as they were measured.
#pragma once

#include <optional>
#include <string_view>

#include "spectra/curve.h"

namespace tessera::spectra {

struct Metal {
  Curve eta, k;
  std::string_view source;
};

/// "Ag", "Al", "Au", "Cr", "Cu", "CuZn" (brass), "Fe", "MgO", "Ni", "Ti", "TiO2".
std::optional<Metal> find_metal(std::string_view name);

/// Reflectance at normal incidence, from air, of a surface with index eta + i k.
double normal_reflectance(double eta, double k);

}  // namespace tessera::spectra
