#include "render/bsdf/tables/boundary_energy.h"

#include <algorithm>
#include <cmath>

#include "render/bsdf/boundary_scatter.h"

namespace tessera::render {

namespace {

const HalfDisk& half_disk(Quadrature quadrature) {
  static const HalfDisk coarse(377, 233), fine(4181, 2584);
  return quadrature == Quadrature::kFine ? fine : coarse;
}

}  // namespace

BoundaryEnergy boundary_energy(double cosine, const BoundaryFacets& facets, double eta,
                               Quadrature quadrature) {
  BoundaryEnergy energy;
  if (facets.alpha == 0) {
    double g;
    energy.reflected = dielectric_reflectance(cosine, eta, g);
    energy.transmitted = 1 - energy.reflected;
    return energy;
  }
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  const ScatteringFacets scattering{facets.alpha, facets.alpha, facets.beckmann, facets.separable_masking};
  scatter_once(sine, 0, cosine, scattering, eta, half_disk(quadrature).points, false,
               [&](double, double, double z, double part) {
                 (z > 0 ? energy.reflected : energy.transmitted) += part;
               });
  return energy;
}

}  // namespace tessera::render
