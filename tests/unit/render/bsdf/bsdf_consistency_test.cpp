// Consistency of sample() and eval() of every model, reciprocity, and inputs at and beyond the edge.
#include <gtest/gtest.h>

#include "support/kernel/bsdf_cases.h"

namespace tessera::test {
namespace {

/// How far densities at one direction may differ. Directions are rounded to 6e-8; that moves the microfacet's
/// normal by about 1e-7 / cos, more when indices are close; ln D changes by at most 2 / alpha a radian. What
/// a smooth coat lets through, by which plastic chooses its lobe, is 1 - R: R is right to 2e-7, and 1 - R no
/// less than 5 cos at grazing angles. cos^n changes by n tan a radian; where it is drawn at all it is above
/// 1e-7, so that tan is below sqrt(32 / n), and the half vector turns by 2e-7 over the length of the sum.
double density_tolerance(const BsdfCase& bsdf, const Direction& wo, const Direction& wi) {
  if (bsdf.kind == render::BsdfKind::kPhong)
    return 1e-5 + std::sqrt(32 * double{bsdf.scalar(0)}) * 2e-7 / (std::abs(wo[2]) + std::abs(wi[2]));
  const double alpha = std::min(bsdf.scalar(0), bsdf.scalar(1));
  if (alpha == 0) return 1e-5 + 4e-8 / std::min(std::abs(wo[2]), std::abs(wi[2]));
  const double spread =
      bsdf.kind == render::BsdfKind::kDielectric ? std::min(1.0, std::abs(bsdf.scalar(2) - 1.0)) : 1.0;
  return 1e-4 + 1e-6 / (alpha * std::max(spread, 1e-3) * std::min(std::abs(wo[2]), std::abs(wi[2])));
}

/// eta^2 - sin^2 at the microfacet that scatters a to b: 0 at the critical angle, 1 where there is none. All
/// else follows from this difference of nearly equal numbers, which is right to 1e-7.
double above_critical(double eta, const Direction& a, const Direction& b) {
  const bool refracted = a[2] * b[2] < 0, a_is_dense = (eta > 1) == (a[2] < 0);
  if (!refracted && !a_is_dense) return 1;
  const Direction& dense = a_is_dense ? a : b;
  const Direction& other = a_is_dense ? b : a;
  const double relative = std::min(eta, 1 / eta);
  Direction h;
  for (int i = 0; i < 3; ++i) h[i] = dense[i] + (refracted ? relative : 1) * other[i];
  const double cosine = dot(dense, h) / std::sqrt(dot(h, h));
  return relative * relative - 1 + cosine * cosine;
}

TEST(BsdfConsistency, WeightIsValueOverDensity) {
  constexpr double kTolerance = 1e-4;
  std::uint64_t seed = 0;
  std::vector<BsdfCase> cases = all_cases();
  const std::size_t models = cases.size();
  for (std::size_t i = 0; i < models; ++i) {
    cases.push_back(cases[i]);
    cases.back().transport = kernel::Transport::kImportance;
  }
  for (const BsdfCase& bsdf : cases) {
    const bool importance = bsdf.transport == kernel::Transport::kImportance;
    for (const Direction& wo : all_wo()) {
      SCOPED_TRACE(bsdf.name + (importance ? ", importance" : "") +
                   ", cos(theta_o) = " + std::to_string(wo[2]));
      int compared = 0;
      bsdf.for_each_sample(wo, 256, ++seed, [&](const Sample& s) {
        if (!s.valid || s.specular) return;
        double tolerance = density_tolerance(bsdf, wo, s.wi);
        // Sampling and evaluation have two such differences each. The reflectance falls with their root, by
        // 2 (1 + eta^2) / cos(theta_o) near the critical angle, where the cosine is that of the angle.
        if (bsdf.kind == render::BsdfKind::kDielectric) {
          const double above = std::max(std::abs(above_critical(bsdf.scalar(2), wo, s.wi)), 1e-9);
          const double eta2 = std::pow(std::max(bsdf.scalar(2), 1 / bsdf.scalar(2)), 2);
          tolerance +=
              s.transmission ? 4e-7 / above : 2e-7 * (1 + eta2) / std::sqrt((1 - 1 / eta2 + 1e-9) * above);
        }
        if (tolerance > 0.05) return;  // single precision cannot say
        ++compared;
        const Eval e = bsdf.eval(wo, s.wi);
        EXPECT_NEAR(e.pdf, s.pdf, s.pdf * tolerance);
        for (int c = 0; c < 3; ++c) {
          // Refracted importance is eta^2 times radiance, and so is what is rounded off.
          // Large values are rounded off in proportion.
          const double weight = std::max(1.0, double{s.weight[c]});
          const double size = weight * (importance ? std::max(1.0, double{s.eta * s.eta}) : 1.0);
          EXPECT_NEAR(e.f_cos[c], s.weight[c] * e.pdf, e.pdf * size * (kTolerance + 0.1 * tolerance));
        }
      });
      const double alpha = std::min(bsdf.scalar(0), bsdf.scalar(1));
      const bool delta = bsdf.sample(wo, 0.9999f, 0.4f, 0.6f).specular;
      if (!delta && alpha >= 0.02 && std::abs(wo[2]) > 0.02 && std::abs(bsdf.scalar(2) - 1) > 0.1) {
        EXPECT_GT(compared, 50);
      }
    }
  }
}

TEST(BsdfConsistency, IsReciprocal) {
  // f(wo, wi) / eta_i^2 = f(wi, wo) / eta_o^2 [Veach 1997, eq. 5.14]; rounding as for densities.
  const Direction directions[] = {direction(5, 0), direction(35, 80), direction(70, 190), direction(110, 260),
                                  direction(160, 10)};
  for (const BsdfCase& bsdf : all_cases()) {
    // Hair tilts the light of one side only; Disney's glass is not reciprocal.
    if (bsdf.kind == render::BsdfKind::kHair || bsdf.kind == render::BsdfKind::kPrincipledThin) continue;
    if (bsdf.flags & render::kHasInside) continue;
    // A coat that leans has cosines with its own normal, as bumps have.
    if (bsdf.upper_normal[2] < 1) continue;
    for (const Direction& a : directions) {
      for (const Direction& b : directions) {
        SCOPED_TRACE(bsdf.name + ", cosines " + std::to_string(a[2]) + " " + std::to_string(b[2]));
        const bool refracted = bsdf.kind == render::BsdfKind::kDielectric && a[2] * b[2] < 0;
        const double eta_b_over_a = !refracted ? 1 : a[2] > 0 ? bsdf.scalar(2) : 1 / bsdf.scalar(2);
        const double there = bsdf.eval(a, b).f_cos[0] / std::abs(b[2]) * eta_b_over_a * eta_b_over_a;
        const double back = bsdf.eval(b, a).f_cos[0] / std::abs(a[2]);
        if (refracted && above_critical(bsdf.scalar(2), a, b) < 2e-3) continue;
        EXPECT_NEAR(there, back, back * (1e-4 + density_tolerance(bsdf, a, b)));
      }
    }
  }
}

TEST(BsdfConsistency, DeltaModelsHaveNoDensity) {
  const Direction wo = direction(40, 0), mirror = direction(40, 180);
  for (const BsdfCase& bsdf : {conductor(0, 0), dielectric(0, 0, 1.5f), dielectric(9e-4f, 9e-4f, 1.5f),
                               dielectric(0.3f, 0.3f, 1), thin_dielectric(1.5f)}) {
    SCOPED_TRACE(bsdf.name);
    EXPECT_EQ(bsdf.eval(wo, mirror).pdf, 0);
    EXPECT_EQ(bsdf.eval(wo, mirror).f_cos[0], 0);
  }
}

/// Parameters, directions and random numbers from the places where formulas break.
class NastyInputs {
 public:
  float scalar() {
    constexpr float kValues[] = {0,    1e-30f, 1e-7f, 9.99e-4f, 1e-3f,      0.1f, 0.5f,
                                 0.8f, 1,      1.5f,  3,        1.0000001f, 100};
    return kValues[random_() % std::size(kValues)];
  }
  float index() { return std::max(scalar(), 0.1f); }
  float u() {
    constexpr float kValues[] = {0, 0x1p-24f, 0.25f, 0.5f, 0.75f, 0x1.fffffep-1f};
    return kValues[random_() % std::size(kValues)];
  }
  Direction direction() {
    constexpr double kValues[] = {0, 1e-20, 1e-8, 1e-4, 0.3, 1};
    Direction w;
    double length = 0;
    do {
      for (double& x : w) x = kValues[random_() % std::size(kValues)] * (random_() % 2 == 0 ? 1 : -1);
      length = std::sqrt(dot(w, w));
    } while (length < 0.1);
    for (double& x : w) x /= length;
    return w;
  }
  int below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }

 private:
  std::mt19937 random_{1};
};

TEST(BsdfConsistency, NastyInputsGiveFiniteResults) {
  NastyInputs nasty;
  const render::BsdfKind kinds[] = {render::BsdfKind::kDiffuse,       render::BsdfKind::kConductor,
                                    render::BsdfKind::kDielectric,    render::BsdfKind::kThinDielectric,
                                    render::BsdfKind::kCoatedDiffuse, render::BsdfKind::kDiffuseTransmission,
                                    render::BsdfKind::kPhong};
  for (int i = 0; i < 600; ++i) {
    const float alpha = std::min(nasty.scalar(), 1.0f),
                other = nasty.below(2) == 0 ? alpha : std::min(nasty.scalar(), 1.0f);
    const BsdfCase bsdf("nasty", kinds[i % std::size(kinds)], {nasty.scalar(), 1, 0}, {nasty.scalar(), 0, 1},
                        {alpha, other, nasty.index()});
    for (int j = 0; j < 100; ++j) {
      const Direction wo = nasty.direction(), wi = nasty.direction();
      const Eval e = bsdf.eval(wo, wi);
      const float u_lobe = nasty.u(), u0 = nasty.u(), u1 = nasty.u();
      const Sample s = bsdf.sample(wo, u_lobe, u0, u1);
      const bool eval_good = std::isfinite(e.pdf) && e.pdf >= 0 && std::isfinite(e.f_cos[0]) &&
                             e.f_cos[0] >= 0 && std::isfinite(e.f_cos[2]) && e.f_cos[2] >= 0;
      // Refraction multiplies the sine, whose square is right to 1e-7, by the index.
      const double index = std::max(bsdf.scalar(2), 1 / bsdf.scalar(2));
      // Weights: at most 1 but for refraction (1 / eta^2, eta >= 0.1 or its inverse), and lobes chosen by
      // energy.
      const bool sample_good =
          !s.valid || (std::isfinite(s.pdf) && s.pdf > 0 && s.weight[0] >= 0 && s.weight[2] >= 0 &&
                       s.weight[0] <= 1.1e4 && std::abs(dot(s.wi, s.wi) - 1) < 1e-5 + 3e-7 * index * index);
      ASSERT_TRUE(eval_good && sample_good)
          << "kind " << static_cast<int>(bsdf.kind) << " alpha " << alpha << " " << other << " eta "
          << bsdf.scalar(2) << " wo " << wo[0] << " " << wo[1] << " " << wo[2] << " wi " << wi[0] << " "
          << wi[1] << " " << wi[2] << " u " << u_lobe << " " << u0 << " " << u1 << ": f " << e.f_cos[0]
          << " pdf " << e.pdf << "; sampled " << s.wi[0] << " " << s.wi[1] << " " << s.wi[2] << " weight "
          << s.weight[0] << " pdf " << s.pdf;
    }
  }
}

}  // namespace
}  // namespace tessera::test
