// The phase function: its density, its samples, its mean cosine.
#include <gtest/gtest.h>

#include "statistical/medium/test_media.h"
#include "support/kernel/chi2.h"

namespace tessera::render::TESSERA_ISA {
namespace {

constexpr float kAsymmetries[] = {0, 0.0005f, 0.3f, -0.6f, 0.9f, -0.95f};
constexpr int kPhaseSamples = 320000;

MediumTable media() {
  MediumTable table;
  for (const float g : kAsymmetries) {
    MediumRecord medium;
    medium.g = g;
    table.media.push_back(medium);
  }
  return table;
}

TEST(Phase, SamplesFollowTheDensity) {
  const MediumTable table = media();
  const Point wo = unit({0.3, -0.5, 0.8});
  const test::SphereGrid grid(40, 40);
  for (int m = 0; m < static_cast<int>(std::size(kAsymmetries)); ++m) {
    SCOPED_TRACE(kAsymmetries[m]);
    std::vector<double> observed(grid.size()), expected(grid.size());
    Random random(1);
    Moments cosine;
    for (int i = 0; i < kPhaseSamples; i += kWidth) {
      const PhaseSample s = sample_phase(table, Int(m), wide(wo), random.next_2d(), Mask::all());
      const Float value = phase_value(table, Int(m), wide(wo), s.wi, Mask::all());
      for (int l = 0; l < kWidth; ++l) {
        const Point wi{s.wi.x.lane(l), s.wi.y.lane(l), s.wi.z.lane(l)};
        ASSERT_NEAR(dot(wi, wi), 1, 1e-5);
        // The density falls off by (1 - g)^2 of a radian or so in the peak; float cosines are off by 1e-7.
        ASSERT_NEAR(s.pdf.lane(l), value.lane(l), 2e-4 * value.lane(l));
        ++observed[grid.cell(wi.x, wi.y, wi.z)];
        cosine.add(-dot(wo, wi));
      }
    }
    double total = 0;
    const auto pdf = [&](double x, double y, double z) {
      const double g = kAsymmetries[m], forward = -dot(wo, {x, y, z});
      return (1 - g * g) /
             (4 * std::numbers::pi * std::pow(1 + g * g - 2 * g * forward, 1.5));  // Henyey & Greenstein
    };
    for (std::size_t cell = 0; cell < grid.size(); ++cell) {
      const double p = test::integrate_cell(pdf, grid.bounds(cell));
      expected[cell] = kPhaseSamples * p;
      total += p;
    }
    EXPECT_NEAR(total, 1, 1e-4);
    EXPECT_GT(test::chi_square_test(observed, expected).p_value,
              test::sidak_level(0.01, std::size(kAsymmetries)));
    // Five standard errors: once in 1.7 million.
    EXPECT_NEAR(cosine.mean(), kAsymmetries[m], 5 * cosine.error());
    // The values of the kernel are those of the formula.
    for (const Point wi :
         {unit({1, 0, 0}), unit({-0.3, 0.5, -0.8}), unit({0.3, -0.5, 0.8}), unit({0, 1, 1})}) {
      const double formula = pdf(wi.x, wi.y, wi.z);
      EXPECT_NEAR(phase_value(table, Int(m), wide(wo), wide(wi), Mask::all()).lane(0), formula,
                  1e-3 * formula);
    }
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
