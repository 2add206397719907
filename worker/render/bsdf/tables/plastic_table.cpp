#include "render/bsdf/tables/plastic_table.h"

#include <algorithm>

namespace tessera::render {

namespace {

/// The part of diffuse light that a smooth boundary reflects; `eta` is the index of the other side over that
/// of the light's side. Fits of 0.1 % for usual indices: [Egan & Hilgeman 1973] below 1, [d'Eon & Irving
/// 2011] from 1 on.
double diffuse_reflectance(double eta) {
  if (eta < 1) return -1.4399 * eta * eta + 0.7099 * eta + 0.6681 + 0.0636 / eta;
  const double x = 1 / eta;
  return 0.919317 + x * (-3.4793 + x * (6.75335 + x * (-7.80989 + x * (4.98554 - 1.36881 * x))));
}

}  // namespace

std::int32_t append_plastic_table(float eta, const BoundaryFacets& facets, MaterialTable& table) {
  const std::size_t offset = table.coat_tables.size();
  if (facets.alpha == 0) {
    table.coat_tables.push_back(static_cast<float>(diffuse_reflectance(1.0 / eta)));
    return static_cast<std::int32_t>(offset);
  }
  table.coat_tables.resize(offset + kPlasticTransmittance + kPlasticCosines);
  float* out = table.coat_tables.data() + offset;
  double internal = 0;
  for (int i = 0; i < kPlasticCosines; ++i) {
    const double cosine = std::max(i / (kPlasticCosines - 1.0), 1e-6);
    out[kPlasticTransmittance + i] =
        static_cast<float>(boundary_energy(cosine, facets, eta, Quadrature::kFine).transmitted);
    internal += 2 * cosine * boundary_energy(cosine, facets, 1.0 / eta, Quadrature::kFine).reflected;
  }
  out[kPlasticInternal] = static_cast<float>(internal / kPlasticCosines);
  return static_cast<std::int32_t>(offset);
}

}  // namespace tessera::render
