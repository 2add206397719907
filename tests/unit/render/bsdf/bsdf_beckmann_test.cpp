#include "render/bsdf/beckmann.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/kernel/bsdf_cases.h"

namespace tessera::test {
namespace {

TEST(Beckmann, ErrorFunctionAndItsInverse) {
  for (float x = -4; x <= 4; x += 0.037f) {
    EXPECT_NEAR(kernel::erf(kernel::Float(x)).lane(0), std::erf(x),
                4e-7);  // 1.5e-7, and four roundings near 1
  }
  for (float v = -0.99999f; v < 1; v += 0.00713f) {
    // erf(erf_inverse(v)) = v: 3e-7 of the slope times at most |x| erf'(x) < 0.5, and rounding.
    EXPECT_NEAR(std::erf(kernel::erf_inverse(kernel::Float(v)).lane(0)), v, 5e-7);
  }
}

TEST(Beckmann, DensityProjectsToOne) {
  // Midpoint rule over t = tan^2(theta) / alpha^2 in [0, 20]: D cos(theta) dm = exp(-t) dt, but for 2e-9 of
  // the tail.
  for (const float alpha : {0.05f, 0.3f, 1.0f}) {
    constexpr int kSteps = 4000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double t = 20.0 * (i + 0.5) / kSteps, tangent = alpha * std::sqrt(t),
                   z = 1 / std::sqrt(1 + tangent * tangent);
      const Direction m{z * tangent, 0, z};
      const double density =
          kernel::beckmann_density(wide(m), kernel::Float(alpha), kernel::Float(alpha)).lane(0);
      // dm = 2 pi sin dtheta = pi alpha^2 z^3 dt
      sum += density * z * M_PI * alpha * alpha * z * z * z * 20 / kSteps;
    }
    EXPECT_NEAR(sum, 1, 1e-4);
  }
}

TEST(Beckmann, MaskingIsThatOfTheSlopes) {
  // G1 = 1 / (1 + Lambda) with Lambda = (erf(a) - 1) / 2 + exp(-a^2) / (2 a sqrt(pi)) [Walter et al. 2007],
  // to 0.35 %.
  for (double a = 0.02; a < 3; a *= 1.1) {
    const double z = a / std::sqrt(1 + a * a), slope = z / a;
    const double s = kernel::beckmann_masking_length(kernel::Float(static_cast<float>(z)),
                                                     kernel::Float(static_cast<float>(slope)))
                         .lane(0);
    const double lambda = 0.5 * (std::erf(a) - 1) + std::exp(-a * a) / (2 * a * std::sqrt(M_PI));
    EXPECT_NEAR(2 * z / (z + s) * (1 + lambda), 1, 3.6e-3) << "a = " << a;
  }
}

}  // namespace
}  // namespace tessera::test
