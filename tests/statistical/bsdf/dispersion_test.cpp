// Dispersion of glTF's glass against Snell's law.
#include <gtest/gtest.h>

#include "support/kernel/bsdf_cases.h"

namespace tessera::test {
namespace {

TEST(Dispersion, RefractsEachComponentByItsIndex) {
  // Facets of alpha 0.001 spread a refracted ray by about that; the mean of 2^16 directions is off by its
  // square, and by twice as much where few of them are there.
  constexpr double kTolerance = 2e-4;
  constexpr float kSpread = 0.05f, kEta = 1.6f;
  const BsdfCase glass = gltf(
      "clear",
      {.roughness = 0, .eta = kEta, .transmission = 1, .volume = true, .base = {1, 1, 1}, .spread = kSpread});
  for (const double theta : {0.0, 20.0, 50.0, 160.0, 148.0}) {
    const Direction wo = direction(theta, 30);
    std::array<Direction, kComponents> mean{};
    Components energy{};
    glass.for_each_even_sample(wo, 1 << 16, [&](const Sample& s) {
      if (!s.valid || !s.transmission) return;
      for (std::size_t c = 0; c < kComponents; ++c) {
        energy[c] += s.weight[c];
        for (std::size_t k = 0; k < 3; ++k) mean[c][k] += s.weight[c] * s.wi[k];
      }
    });
    for (std::size_t c = 0; c < kComponents; ++c) {
      SCOPED_TRACE("theta " + std::to_string(theta) + ", component " + std::to_string(c));
      const double eta = theta < 90 ? glass.index(c) : 1 / glass.index(c);
      ASSERT_GT(energy[c], 0);
      for (std::size_t k = 0; k < 2; ++k) EXPECT_NEAR(mean[c][k] / energy[c], -wo[k] / eta, kTolerance);
    }
  }
}

}  // namespace
}  // namespace tessera::test
