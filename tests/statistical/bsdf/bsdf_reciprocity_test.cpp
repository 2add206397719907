// Over a million pairs of directions, importance is scattered from one to the other as radiance is the other
// way round: f*(wo, wi) = f(wi, wo) [Veach 1997, eqs. 3.31 and 5.14].
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "statistical/bsdf/density_check.h"

namespace tessera::test {
namespace {

/// Models that are not reciprocal by the definition of their format: hair tilts the light of one side only;
/// Disney's glass divides nothing by eta^2, and its thin sheet scales one direction; the walks of coated
/// conductors are noise.
bool is_reciprocal(const BsdfCase& bsdf) {
  return bsdf.kind != render::BsdfKind::kHair && bsdf.kind != render::BsdfKind::kPrincipledThin &&
         (bsdf.kind != render::BsdfKind::kPrincipled || (bsdf.flags & render::kHasInside) == 0);
}

struct Pairs {
  Direction there[16], back[16];
};

/// Half of the pairs anywhere, half where the model scatters much: at samples.
Pairs random_pairs(const BsdfCase& bsdf, bool sampled, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform;
  Pairs pairs;
  for (int i = 0; i < 16; ++i) {
    for (Direction* w : {&pairs.there[i], &pairs.back[i]}) {
      const double z = 2 * uniform(random) - 1, phi = 2 * M_PI * uniform(random), r = std::sqrt(1 - z * z);
      *w = {r * std::cos(phi), r * std::sin(phi), z};
    }
  }
  if (!sampled) return pairs;
  int i = 0;
  kernel::BsdfSample s =
      bsdf.sample(wide(pairs.there), kernel::Float(static_cast<float>(uniform(random))),
                  {static_cast<float>(uniform(random)), static_cast<float>(uniform(random))});
  BsdfCase::for_each_lane(s, [&](const Sample& sample) {
    if (sample.valid) pairs.back[i] = sample.wi;
    ++i;
  });
  return pairs;
}

/// The roughness of the narrowest facets.
double least_alpha(const BsdfCase& bsdf) {
  if (bsdf.kind != render::BsdfKind::kGltf) return std::min(bsdf.scalar(0), bsdf.scalar(1));
  const float coat = bsdf.extended(render::slot::kCoat) > 0 ? bsdf.extended(render::slot::kCoatRoughness) : 1;
  return std::pow(std::min(bsdf.scalar(render::slot::kRoughness), coat), 2);
}

/// Error of a value where direction vectors of single precision, wrong by 1e-7, are all that
/// both ways have in common: they move the normal of the microfacet by about 1e-7 / cos, which changes ln D
/// by at most 2 / alpha a radian. Infinite near the critical angle: there eta^2 - sin^2 is a difference of
/// nearly equal numbers.
double rounding(const BsdfCase& bsdf, std::size_t channel, const Direction& a, const Direction& b) {
  const double alpha = std::max(least_alpha(bsdf), 1e-4);
  const double cosine = std::min(std::abs(a[2]), std::abs(b[2]));
  constexpr double kNearlyCritical = 5e-3;  // g^2 = eta^2 - sin^2
  double spread = 1;
  const bool refracts = bsdf.kind == render::BsdfKind::kDielectric || (bsdf.flags & render::kHasInside) != 0;
  if (!refracts) return 2e-6 / (alpha * cosine);
  const double index = bsdf.index(channel), eta = a[2] > 0 ? index : 1 / index;
  if (a[2] * b[2] > 0) {
    const double g2 = (eta - 1) * (eta + 1) + 0.5 * (1 + dot(a, b));
    if (std::abs(g2) < kNearlyCritical) return std::numeric_limits<double>::infinity();
  } else {
    Direction h{a[0] + eta * b[0], a[1] + eta * b[1], a[2] + eta * b[2]};
    const double length = std::sqrt(dot(h, h)),
                 across = std::min(std::abs(dot(a, h)), std::abs(dot(b, h))) / length;
    if (across * across < kNearlyCritical) return std::numeric_limits<double>::infinity();
    spread = std::min(1.0, std::abs(eta - 1)) * std::min(1.0, length) * across * across;
  }
  return 2e-6 / (alpha * std::max(spread * cosine, 1e-9));
}

TEST(BsdfReciprocity, HoldsForAMillionPairs) {
  constexpr double kTolerance = 1e-4;
  const std::vector<BsdfCase> cases = all_cases();
  std::mt19937_64 random(5);
  std::int64_t compared = 0, dark = 0, unresolved = 0;
  const int rounds = 2'000'000 / 16 / static_cast<int>(cases.size());
  for (const BsdfCase& bsdf : cases) {
    if (!is_reciprocal(bsdf)) continue;
#ifdef TESSERA_SPECTRAL
    // Paths of one wavelength alone meet what disperses: the others are at no direction of their own.
    if (bsdf.further[render::slot::kSpread] != 0) continue;
#endif
    BsdfCase adjoint = bsdf;
    adjoint.transport = kernel::Transport::kImportance;
    SCOPED_TRACE(bsdf.name);
    double worst = 0;
    int violations = 0;
    for (int round = 0; round < rounds; ++round) {
      const Pairs pairs = random_pairs(bsdf, round % 2 == 1, random);
      const kernel::Vec3 a = wide(pairs.there), b = wide(pairs.back);
      const auto c = static_cast<std::size_t>(round) % kComponents;
      float there[16], back[16];
      store(adjoint.eval(a, b).f_cos.c[c], there);
      store(bsdf.eval(b, a).f_cos.c[c], back);
      for (int i = 0; i < 16; ++i) {
        const Direction &from = pairs.there[i], &to = pairs.back[i];
        const double x = there[i] / std::abs(to[2]), y = back[i] / std::abs(from[2]);
        const double tolerance = kTolerance + rounding(bsdf, c, from, to);
        if (std::max(x, y) < 1e-12) {
          ++dark;
          continue;
        }
        if (tolerance > 0.05) {
          ++unresolved;
          continue;
        }
        ++compared;
        const double error = std::abs(x - y) / std::max(x, y);
        worst = std::max(worst, error / tolerance);
        violations += error > tolerance;
      }
    }
    EXPECT_EQ(violations, 0) << "worst " << worst << " times what is allowed";
  }
  EXPECT_GT(compared, 1'000'000);
  std::printf("compared %lld, dark %lld, beyond single precision %lld\n", static_cast<long long>(compared),
              static_cast<long long>(dark), static_cast<long long>(unresolved));
  EXPECT_LT(unresolved, compared / 2);
}

}  // namespace
}  // namespace tessera::test
