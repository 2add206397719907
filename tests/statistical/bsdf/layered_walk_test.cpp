// The closed form of coated_diffuse.h against what it stands for: a random walk between a rough boundary and
// a Lambertian base.
#include <gtest/gtest.h>

#include "statistical/bsdf/rough_boundary.h"

namespace tessera::test {
namespace {

struct WalkEstimate {
  double mean, standard_error;
};

/// f(wo, wi) of the light that visits the base, by walks from wo. At each visit of the base, light from wi is
/// brought in by scattering it once at the coat.
WalkEstimate walk(const RoughBoundary& from_above, const RoughBoundary& from_below, double eta, double rho,
                  const Direction& wo, const Direction& wi, int walks, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform;
  double sum = 0, sum_of_squares = 0;
  for (int i = 0; i < walks; ++i) {
    double f = 0;
    const auto entered = from_above.scatter(wo, random);
    if (entered && entered->transmitted) {
      double beta = entered->weight / (eta * eta);  // radiance is smaller outside
      while (true) {
        const auto light = from_above.scatter(wi, random);
        if (light && light->transmitted) f += beta * light->weight * rho / M_PI;
        const double r = std::sqrt(uniform(random)), phi = 2 * M_PI * uniform(random);
        const Direction up{r * std::cos(phi), r * std::sin(phi), std::sqrt(1 - r * r)};
        const auto back = from_below.scatter(up, random);
        if (!back || back->transmitted) break;
        beta *= rho * back->weight;
        // Go on by the energy that is left.
        const double survival = std::min(1.0, beta * eta * eta);
        if (uniform(random) >= survival) break;
        beta /= survival;
      }
    }
    sum += f;
    sum_of_squares += f * f;
  }
  const double mean = sum / walks;
  return {mean, std::sqrt(std::max(0.0, sum_of_squares / walks - mean * mean) / walks)};
}

void expect_like_walk(double alpha_x, double alpha_y, double eta, double rho, double relative_tolerance) {
  constexpr int kWalks = 60000;
  const float value = static_cast<float>(rho);
  const BsdfCase bsdf = coated_diffuse(static_cast<float>(alpha_x), static_cast<float>(alpha_y),
                                       static_cast<float>(eta), {value, value, value});
  const RoughBoundary from_above(alpha_x, alpha_y, eta), from_below(alpha_x, alpha_y, 1 / eta);
  const Direction wis[] = {direction(20, 110), direction(65, 250)};
  std::uint64_t seed = 1;
  for (const Direction& wo : {direction(0, 0), direction(45, 30), direction(80, 75)}) {
    for (const Direction& wi : wis) {
      SCOPED_TRACE(bsdf.name + ", rho " + std::to_string(rho) + ", cosines " + std::to_string(wo[2]) + " " +
                   std::to_string(wi[2]));
      const WalkEstimate base = walk(from_above, from_below, eta, rho, wo, wi, kWalks, seed++);
      const double expected = base.mean + from_above.reflection(wo, wi);
      const double f = bsdf.eval(wo, wi).f_cos[0] / wi[2];
      EXPECT_NEAR(f, expected, 4 * base.standard_error + relative_tolerance * expected);
    }
  }
}

// 4 standard errors: with 54 comparisons, all pass with probability 0.997. The tables add 1e-3 of each
// transmittance, 2e-3 of the product, and 1e-3 to R_int, about 1 - 1 / eta^2, which interreflection
// magnifies.
double table_tolerance(double eta, double rho) {
  return 2e-3 + 1e-3 * rho / (1 - rho * (1 - 1 / (eta * eta)));
}

TEST(CoatedDiffuse, AgreesWithALayeredRandomWalk) {
  for (const double alpha : {0.05, 0.3, 0.8}) {
    expect_like_walk(alpha, alpha, 1.5, 0.8, table_tolerance(1.5, 0.8));
    expect_like_walk(alpha, alpha, 1.5, 0.2, table_tolerance(1.5, 0.2));
    expect_like_walk(alpha, alpha, 2.2, 1.0, table_tolerance(2.2, 1.0));
  }
}

TEST(CoatedDiffuse, SmoothCoatAgreesWithALayeredRandomWalk) {
  // The reference cannot be smooth; at alpha = 0.001 its energies are those of a mirror to about alpha^2.
  const BsdfCase bsdf = coated_diffuse(0, 0, 1.5f, {0.7f, 0.7f, 0.7f});
  const RoughBoundary from_above(1e-3, 1e-3, 1.5), from_below(1e-3, 1e-3, 1 / 1.5);
  const Direction wo = direction(45, 30), wi = direction(65, 250);
  const WalkEstimate base = walk(from_above, from_below, 1.5, 0.7, wo, wi, 200000, 1);
  EXPECT_NEAR(bsdf.eval(wo, wi).f_cos[0] / wi[2], base.mean, 4 * base.standard_error + 1e-5);
}

TEST(CoatedDiffuse, AnisotropicCoatIsCloseToALayeredRandomWalk) {
  // An isotropic roughness stands in for the energies: "a few percent" of coated_diffuse.h.
  expect_like_walk(0.05, 0.2, 1.5, 0.8, 0.02);
  expect_like_walk(0.5, 0.1, 1.5, 0.8, 0.06);
}

}  // namespace
}  // namespace tessera::test
