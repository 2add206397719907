// sample() of every model against the density that eval() claims.
#include <gtest/gtest.h>

#include "statistical/bsdf/partition.h"

namespace tessera::test {
namespace {

/// Where lobes may be narrow: wo reflected and refracted at the surface's normal; straight on, for grazing light along
/// the horizon too; and for strongly anisotropic surfaces at normals tilted along the rough axis.
std::vector<Direction> peaks_of(const BsdfCase& bsdf, const Direction& wo) {
  std::vector<Direction> normals{{0, 0, 1}};
  const bool rough_x = bsdf.scalar(0) > 4 * bsdf.scalar(1), rough_y = bsdf.scalar(1) > 4 * bsdf.scalar(0);
  if (rough_x || rough_y) {
    for (int degrees = -88; degrees <= 88; degrees += 2) normals.push_back(direction(degrees, rough_x ? 0 : 90));
  }
  const double eta = wo[2] > 0 ? bsdf.scalar(2) : 1 / bsdf.scalar(2);
  std::vector<Direction> peaks{{-wo[0], -wo[1], -wo[2]}};
  if (std::abs(wo[2]) < 0.01) {
    const double forward = std::atan2(-wo[1], -wo[0]) * 180 / M_PI;
    for (int degrees = -60; degrees <= 60; degrees += 4) peaks.push_back(direction(90, forward + degrees));
  }
  for (const Direction& n : normals) {
    const double cosine = dot(wo, n);
    peaks.push_back({2 * cosine * n[0] - wo[0], 2 * cosine * n[1] - wo[1], 2 * cosine * n[2] - wo[2]});
    const double cos2 = 1 - (1 - cosine * cosine) / (eta * eta);
    if (bsdf.kind != render::BsdfKind::kDielectric || cos2 <= 0) continue;
    const double along = cosine / eta - std::copysign(std::sqrt(cos2), cosine);
    peaks.push_back({along * n[0] - wo[0] / eta, along * n[1] - wo[1] / eta, along * n[2] - wo[2] / eta});
  }
  return peaks;
}

/// Of the lobe around a peak: seen from a grazing direction it is foreshortened, and refraction with nearly equal
/// indices hardly spreads it.
double peak_radius(const BsdfCase& bsdf, const Direction& wo) {
  const double alpha = std::min(bsdf.scalar(0), bsdf.scalar(1));
  const double spread =
      bsdf.kind == render::BsdfKind::kDielectric ? std::min(1.0, std::abs(bsdf.scalar(2) - 1.0) + 1e-3) : 1.0;
  return 0.5 * alpha * spread * std::max(std::abs(wo[2]), 1e-3);
}

/// Directions in single precision cannot resolve the foreshortened lobes of the smoothest surfaces: at 89.9 degrees
/// and alpha 0.001 they are 2e-6 wide, 30 units in the last place.
bool resolvable(const BsdfCase& bsdf, const Direction& wo) {
  const float alpha = std::min(bsdf.scalar(0), bsdf.scalar(1));
  return alpha == 0 || alpha * std::abs(wo[2]) > 1e-5;
}

Partition partition_of(const BsdfCase& bsdf, const Direction& wo) {
  const auto pdf = [&, wide_wo = wide(wo)](const Direction(&wi)[16], float(&values)[16]) {
    store(bsdf.eval(wide_wo, wide(wi)).pdf, values);
  };
  return Partition(pdf, peaks_of(bsdf, wo), peak_radius(bsdf, wo));
}

TEST(BsdfChiSquare, SamplesFollowThePdfWhichIntegratesToOne) {
  constexpr int kSamples = 1 << 15;
  // The share of samples without a density is also computed as a mean over n evenly spread points in three dimensions,
  // of an integrand with edges: its error falls as about n^-2/3 = 4e-4. Quadrature adds up to 1000 cells times 5e-7.
  constexpr int kEvenSamples = 1 << 17;
  constexpr double kIntegralTolerance = 1e-3;
  const std::vector<BsdfCase> cases = all_cases();
  const std::vector<Direction> directions = all_wo();
  const double level = sidak_level(0.01, static_cast<int>(cases.size() * directions.size()));
  std::uint64_t seed = 0;
  for (const BsdfCase& bsdf : cases) {
    for (const Direction& wo : directions) {
      if (!resolvable(bsdf, wo)) continue;
      SCOPED_TRACE(bsdf.name + ", cos(theta_o) = " + std::to_string(wo[2]));
      const Partition partition = partition_of(bsdf, wo);

      int without_density = 0;
      bsdf.for_each_even_sample(wo, kEvenSamples, [&](const Sample& s) { without_density += !s.valid || s.specular; });
      // Beckmann's densities are wrong by one factor for each wo: the masking of wo is an approximation to 0.35 %.
      const bool approximate = (bsdf.flags & render::kBeckmann) != 0;
      const double sum = partition.total() + static_cast<double>(without_density) / kEvenSamples;
      EXPECT_NEAR(sum, 1, kIntegralTolerance + (approximate ? 3.5e-3 : 0));

      // The last cell is for samples without a density: delta lobes, and no direction at all.
      const std::size_t cells = partition.masses().size();
      std::vector<double> observed(cells + 1), expected(cells + 1);
      bsdf.for_each_sample(wo, kSamples, ++seed, [&](const Sample& sample) {
        ++observed[sample.valid && !sample.specular ? static_cast<std::size_t>(partition.cell(sample.wi)) : cells];
      });
      const double total = partition.total() / (approximate ? sum : 1), scale = total / partition.total();
      for (std::size_t i = 0; i < cells; ++i) expected[i] = kSamples * partition.masses()[i] * scale;
      expected[cells] = kSamples * std::max(1 - total, 0.0);
      const ChiSquareResult result = chi_square_test(observed, expected);
      EXPECT_GT(result.p_value, level) << "statistic " << result.statistic << " with " << result.degrees_of_freedom
                                       << " degrees of freedom";
    }
  }
}

}  // namespace
}  // namespace tessera::test
