// The walks of coated_conductor.h: their estimates of the same light from two sides must agree, and closed
// forms where there are some.
#include <gtest/gtest.h>

#include "support/kernel/bsdf_cases.h"

namespace tessera::test {
namespace {

BsdfCase coated_conductor(float coat, float base, float eta = 1.5f, float thickness = 0,
                          BsdfCase::Color index = kCopperEta, BsdfCase::Color k = kCopperK) {
  return {"coated conductor " + number(coat) + " " + number(base),
          render::BsdfKind::kCoatedConductor,
          index,
          k,
          {coat, coat, eta},
          0,
          {base, base, thickness}};
}

/// Mean and standard error of n values.
struct Mean {
  double sum = 0, squares = 0;
  int n = 0;
  void add(double x) { sum += x, squares += x * x, ++n; }
  double value() const { return sum / n; }
  double error() const { return std::sqrt(std::max(squares / n - value() * value(), 0.0) / n); }
};

/// How much of the light from a cap of directions around the mirror direction reaches wo: by samples, and by
/// eval() at directions spread evenly over the cap.
void expect_agreement(const BsdfCase& bsdf, const Direction& wo, double cap_cosine) {
  const Direction axis{-wo[0], -wo[1], wo[2]};
  Mean sampled, evaluated;
  bsdf.for_each_sample(wo, 1 << 17, 7, [&](const Sample& s) {
    const bool inside = s.valid && !s.specular && dot(s.wi, axis) > cap_cosine && s.wi[2] > 0;
    sampled.add(inside ? s.weight[0] : 0);
  });
  const double area = 2 * M_PI * (1 - cap_cosine);
  const Direction across{axis[2], 0, -axis[0]};
  const double length = std::sqrt(dot(across, across));
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform;
  for (int i = 0; i < 1 << 15; ++i) {
    const double c = 1 - (1 - cap_cosine) * uniform(random), s = std::sqrt(1 - c * c),
                 phi = 2 * M_PI * uniform(random);
    Direction wi;
    const Direction third{axis[1] * across[2] - axis[2] * across[1],
                          axis[2] * across[0] - axis[0] * across[2],
                          axis[0] * across[1] - axis[1] * across[0]};
    for (int k = 0; k < 3; ++k)
      wi[k] = axis[k] * c + s * (across[k] * std::cos(phi) + third[k] * std::sin(phi)) / length;
    evaluated.add(wi[2] > 0 ? bsdf.eval(wo, wi).f_cos[0] * area : 0);
  }
  // Four standard errors of both: with 18 comparisons, all pass with probability 0.999. Walks are cut off at
  // 1e-3.
  EXPECT_NEAR(sampled.value(), evaluated.value(),
              4 * std::hypot(sampled.error(), evaluated.error()) + 1e-3 * sampled.value());
}

TEST(CoatedConductor, SamplesAndValuesAgree) {
  for (const auto& [coat, base] : {std::array{0.0f, 0.3f}, std::array{0.3f, 0.0f}, std::array{0.2f, 0.4f}}) {
    for (const Direction& wo : {direction(0, 0), direction(40, 0), direction(70, 0)}) {
      for (const double cap : {0.9, 0.3}) {
        const BsdfCase bsdf = coated_conductor(coat, base, 1.5f, 0.1f);
        SCOPED_TRACE(bsdf.name + ", cosine " + std::to_string(wo[2]) + ", cap " + std::to_string(cap));
        expect_agreement(bsdf, wo, cap);
      }
    }
  }
}

TEST(CoatedConductor, SmoothLayersAreAGeometricSeries) {
  // R + T^2 C / (1 - R C), C being the conductor's reflectance from inside the coat; 2^16 walks with weights
  // up to 1.
  const BsdfCase bsdf = coated_conductor(0, 0), coat = dielectric(0, 0, 1.5f);
  BsdfCase::Color eta = kCopperEta, k = kCopperK;
  for (int c = 0; c < 3; ++c) eta[c] /= 1.5f, k[c] /= 1.5f;
  const BsdfCase base = conductor(0, 0, eta, k);
  for (const double theta : {0.0, 50.0, 80.0}) {
    const Direction wo = direction(theta, 30);
    const Direction inside = direction(std::asin(std::sin(theta * M_PI / 180) / 1.5) * 180 / M_PI, 30);
    const double r = coat.sample(wo, 0, 0.5f, 0.5f).pdf;
    std::array<Mean, kComponents> mean;
    bsdf.for_each_sample(wo, 1 << 16, 5, [&](const Sample& s) {
      ASSERT_TRUE(s.valid && s.specular);
      for (std::size_t c = 0; c < kComponents; ++c) mean[c].add(s.weight[c]);
    });
    for (std::size_t c = 0; c < kComponents; ++c) {
      const double metal = base.sample(inside, 0.5f, 0.5f, 0.5f).weight[c];
      EXPECT_NEAR(mean[c].value(), r + (1 - r) * (1 - r) * metal / (1 - r * metal),
                  4 * mean[c].error() + 1e-5);
    }
  }
}

TEST(CoatedConductor, CreatesNoEnergy) {
  for (const auto& [coat, base] : {std::array{0.0f, 0.5f}, std::array{0.5f, 0.0f}, std::array{0.7f, 0.7f}}) {
    const BsdfCase bsdf = coated_conductor(coat, base, 1.5f, 0, {0, 0, 0}, {3, 3, 3});
    for (const Direction& wo : all_wo()) {
      SCOPED_TRACE(bsdf.name + ", cosine " + std::to_string(wo[2]));
      Mean mean;
      bsdf.for_each_sample(wo, 1 << 15, 5, [&](const Sample& s) { mean.add(s.valid ? s.weight[0] : 0); });
      EXPECT_LT(mean.value(), 1 + 4 * mean.error() + 1e-6);
    }
  }
}

}  // namespace
}  // namespace tessera::test
