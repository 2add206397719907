#include "render/bsdf/tables/plastic_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tessera::render {
namespace {

struct SampledEnergy {
  BoundaryEnergy mean, standard_error;
};

/// Share of the light at `cosine` that single scattering on Beckmann or GGX microfacets with separable
/// masking lets through or reflects, by normals drawn with D cos(theta).
SampledEnergy sampled_energy(double cosine, const BoundaryFacets& facets, double eta, int samples) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform;
  const double sine = std::sqrt(1 - cosine * cosine), a2 = facets.alpha * facets.alpha;
  const auto g1 = [&](double z) {
    z = std::abs(z);
    const double tangent2 = (1 - z * z) / (z * z);
    if (!facets.beckmann) return 2 / (1 + std::sqrt(1 + a2 * tangent2));
    const double a = 1 / std::sqrt(std::max(a2 * tangent2, 1e-30));
    return a >= 1.6 ? 1 : (3.535 * a + 2.181 * a * a) / (1 + 2.276 * a + 2.577 * a * a);
  };
  BoundaryEnergy sum, squares;
  for (int i = 0; i < samples; ++i) {
    const double u = uniform(random), phi = 2 * M_PI * uniform(random);
    const double tangent2 = facets.beckmann ? -a2 * std::log(1 - u) : a2 * u / (1 - u);
    const double mz = 1 / std::sqrt(1 + tangent2), mx = mz * std::sqrt(tangent2) * std::cos(phi);
    const double c = sine * mx + cosine * mz;
    if (c <= 0) continue;
    const double visible = g1(cosine) * c / (cosine * mz);
    const double g2 = (eta - 1) * (eta + 1) + c * c, g = std::sqrt(std::max(g2, 0.0));
    const double s = (c - g) / (c + g), p = (eta * eta * c - g) / (eta * eta * c + g);
    const double fresnel = g2 <= 0 ? 1 : 0.5 * (s * s + p * p);
    const double up = 2 * c * mz - cosine, down = ((c - g) * mz - cosine) / eta;
    const double reflected = up > 0 ? visible * fresnel * g1(up) : 0;
    const double transmitted = g2 > 0 && down < 0 ? visible * (1 - fresnel) * g1(down) : 0;
    sum.reflected += reflected, squares.reflected += reflected * reflected;
    sum.transmitted += transmitted, squares.transmitted += transmitted * transmitted;
  }
  const auto error = [&](double total, double total_squares) {
    return std::sqrt(std::max(total_squares / samples - total * total / samples / samples, 0.0) / samples);
  };
  return {{sum.reflected / samples, sum.transmitted / samples},
          {error(sum.reflected, squares.reflected), error(sum.transmitted, squares.transmitted)}};
}

TEST(PlasticTable, EnergiesAreThoseOfSingleScattering) {
  // Four standard errors: with 32 comparisons, all pass with probability 0.998. 4 / 4181 for the quadrature.
  constexpr double kQuadrature = 1e-3;
  for (const bool beckmann : {false, true}) {
    for (const double alpha : {0.05, 0.4}) {
      const BoundaryFacets facets{alpha, beckmann, true};
      for (const double eta : {1.5, 1 / 1.5}) {
        for (const double cosine : {0.3, 0.9}) {
          const BoundaryEnergy table = boundary_energy(cosine, facets, eta, Quadrature::kFine);
          const auto [mean, error] = sampled_energy(cosine, facets, eta, 1 << 20);
          EXPECT_NEAR(table.reflected, mean.reflected, 4 * error.reflected + kQuadrature)
              << alpha << " " << cosine;
          EXPECT_NEAR(table.transmitted, mean.transmitted, 4 * error.transmitted + kQuadrature)
              << alpha << " " << cosine;
        }
      }
    }
  }
}

TEST(PlasticTable, SmoothCoatsHaveTheFittedReflectance) {
  // Exact values by quadrature of Fresnel's equations: 0.59623 inside 1.5, 0.09178 outside; the fits are good
  // to 0.1 %.
  MaterialTable table;
  const auto inside = static_cast<std::size_t>(append_plastic_table(1.5f, {}, table));
  const auto outside = static_cast<std::size_t>(append_plastic_table(1 / 1.5f, {}, table));
  EXPECT_NEAR(table.coat_tables[inside + kPlasticInternal], 0.59623, 1e-3);
  EXPECT_NEAR(table.coat_tables[outside + kPlasticInternal], 0.09178, 2e-4);
}

TEST(PlasticTable, RoughCoatsTakeTheMeanOver64Cosines) {
  // A coat of alpha 0.001 has the energies of a smooth one, and the mean of 2 c R(c) over i / 63 is 63/64 of
  // the integral plus half of the ends / 64.
  MaterialTable table;
  const auto offset = static_cast<std::size_t>(append_plastic_table(1.5f, {0.001, false, true}, table));
  const double expected = (63 * 0.59623 + 0.04) / 64;
  // The trapezoidal rule stumbles at the critical angle: by 2 c times half a step of 1 / 63 at most, where c
  // = 0.745.
  EXPECT_NEAR(table.coat_tables[offset + kPlasticInternal], expected, 0.012);
  EXPECT_NEAR(table.coat_tables[offset + kPlasticTransmittance + 63], 0.96, 1e-3);
}

}  // namespace
}  // namespace tessera::render
