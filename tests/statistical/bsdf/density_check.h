// Whether the samples of a model follow the density that it claims, and that integrates to one.
#pragma once

#include <gtest/gtest.h>

#include <optional>

#include "statistical/bsdf/half_vector_map.h"
#include "statistical/bsdf/partition.h"

namespace tessera::test {

/// The map that spreads the lobes of a model with microfacets.
inline std::optional<HalfVectorMap> map_of(const BsdfCase& bsdf, const Direction& wo) {
  using enum render::BsdfKind;
  constexpr double kSmallest = 1e-3;  // mirrors have any map
  const auto alpha = [&](int i) { return std::max<double>(bsdf.scalar(i), kSmallest); };
  switch (bsdf.kind) {
    case kCoatedDiffuse:
    case kPlastic: {
      // Without too narrow a place for the base.
      const double least = 0.1 * std::max(alpha(0), alpha(1));
      return HalfVectorMap(std::max(alpha(0), least), std::max(alpha(1), least), bsdf.scalar(2),
                           HalfVectorMap::Transmission::kRefracts, wo);
    }
    case kConductor:
    case kDielectric:
      return HalfVectorMap(alpha(0), alpha(1), bsdf.kind == kConductor ? 1.5 : bsdf.scalar(2),
                           HalfVectorMap::Transmission::kRefracts, wo);
    case kPrincipled:
    case kPrincipledThin: {
      const double aspect = std::sqrt(1 - 0.9 * bsdf.scalar(1)), alpha2 = bsdf.scalar(0) * bsdf.scalar(0);
      return HalfVectorMap(std::max(alpha2 / aspect, kSmallest), std::max(alpha2 * aspect, kSmallest),
                           bsdf.scalar(2),
                           bsdf.kind == kPrincipled ? HalfVectorMap::Transmission::kRefracts
                                                    : HalfVectorMap::Transmission::kMirrors,
                           wo);
    }
    case kGltf: {
      // No index stands for all that disperse: some directions are reached by one of them alone.
      if (bsdf.further[render::slot::kSpread] != 0) return std::nullopt;
      // The anisotropy may be turned any way.
      const double alpha2 = bsdf.scalar(0) * bsdf.scalar(0), strength = bsdf.scalar(1) * bsdf.scalar(1);
      const double mean = std::max(std::sqrt(alpha2 * (alpha2 + (1 - alpha2) * strength)), kSmallest);
      return HalfVectorMap(mean, mean, bsdf.scalar(2),
                           (bsdf.flags & render::kHasInside) != 0 ? HalfVectorMap::Transmission::kRefracts
                                                                  : HalfVectorMap::Transmission::kMirrors,
                           wo);
    }
    default:
      return std::nullopt;
  }
}

/// Directions in single precision cannot resolve the foreshortened lobes of the smoothest surfaces: at 89.9
/// degrees and alpha 0.001 they are 2e-6 wide, 30 units in the last place; and refraction between nearly
/// equal indices spreads light as much less as these differ.
inline bool resolvable(const BsdfCase& bsdf, const Direction& wo) {
  const float alpha = std::min(bsdf.scalar(0), bsdf.scalar(1));
  const double spread =
      bsdf.kind == render::BsdfKind::kDielectric ? std::min(1.0, std::abs(bsdf.scalar(2) - 1.0)) : 1.0;
  return alpha == 0 || alpha * std::abs(wo[2]) * spread > 1e-5;
}

/// 32 directions, with those of all_wo(): half of them grazing, a third from below.
inline std::vector<Direction> many_wo() {
  std::vector<Direction> result = all_wo();
  for (const double theta :
       {1.0,  10.0, 20.0, 40.0, 45.0, 50.0, 65.0,  70.0,  75.0,  80.0,  82.0,  84.0, 86.0,
        87.0, 88.0, 89.0, 90.1, 91.0, 95.0, 100.0, 110.0, 125.0, 138.0, 165.0, 180.0}) {
    result.push_back(direction(theta, 137.5 * static_cast<double>(result.size())));
  }
  return result;
}

/// The density of sample() at sixteen points of the map's domain, which without a map is that of directions.
inline auto claimed_density(const BsdfCase& bsdf, const Direction& wo,
                            const std::optional<HalfVectorMap>& map) {
  return [&bsdf, &map, wide_wo = wide(wo)](const Direction(&q)[16], float(&values)[16]) {
    Direction wi[16];
    double jacobian[16];
    for (int i = 0; i < 16; ++i) {
      const HalfVectorMap::Mapped mapped = map ? map->direction_of(q[i]) : HalfVectorMap::Mapped{q[i], 1};
      wi[i] = mapped.wi, jacobian[i] = mapped.jacobian;
    }
    store(bsdf.eval(wide_wo, wide(wi)).pdf, values);
    for (int i = 0; i < 16; ++i)
      values[i] = static_cast<float>(jacobian[i] > 0 ? values[i] * jacobian[i] : 0);
  };
}

/// One model seen from one direction; `level` is that of the chi-square test, `seed` of its samples. Returns
/// the part of the samples that find no direction.
inline double expect_samples_follow_pdf(const BsdfCase& bsdf, const Direction& wo, double level,
                                        std::uint64_t seed) {
  SCOPED_TRACE(bsdf.name + ", cos(theta_o) = " + std::to_string(wo[2]));
  constexpr int kSamples = 1 << 14;
  // The share of samples without a density is also computed as a mean over n evenly spread points in three
  // dimensions, of an integrand with edges: its error falls as about n^-2/3 = 4e-4. Quadrature adds up to
  // 1000 cells times 5e-7.
  constexpr int kEvenSamples = 1 << 17;
  constexpr double kIntegralTolerance = 1e-3;
  // 1024 cells. The map straightens the lobe of one index: with three, the edges of the others run across
  // cells, and at grazing angles 1.2e-3 of the density hid between the points of quadrature.
  const bool several_indices = bsdf.further[render::slot::kSpread] != 0;
  const int least_depth = several_indices ? 7 : 4;
  const std::optional<HalfVectorMap> map = map_of(bsdf, wo);
  const Partition partition(claimed_density(bsdf, wo, map), {}, 0, least_depth);

  int without_density = 0, failed = 0;
  bsdf.for_each_even_sample(wo, kEvenSamples, [&](const Sample& s) {
    without_density += !s.valid || s.specular;
    failed += !s.valid;
  });
  // Beckmann's densities are wrong by one factor for each wo: the masking of wo is an approximation to 0.35
  // %.
  const bool approximate = (bsdf.variants & render::kBeckmann) != 0;
  const double sum = partition.total() + static_cast<double>(without_density) / kEvenSamples;
  EXPECT_NEAR(sum, 1, kIntegralTolerance + (approximate ? 3.5e-3 : 0));

  // The last cell is for samples without a density: delta lobes, and no direction at all.
  const std::size_t cells = partition.masses().size();
  std::vector<double> observed(cells + 1), expected(cells + 1);
  bsdf.for_each_sample(wo, kSamples, seed, [&](const Sample& sample) {
    const bool dense = sample.valid && !sample.specular;
    ++observed[dense ? static_cast<std::size_t>(partition.cell(map ? map->point_of(sample.wi) : sample.wi))
                     : cells];
  });
  const double total = partition.total() / (approximate ? sum : 1), scale = total / partition.total();
  for (std::size_t i = 0; i < cells; ++i) expected[i] = kSamples * partition.masses()[i] * scale;
  expected[cells] = kSamples * std::max(1 - total, 0.0);
  const ChiSquareResult result = chi_square_test(observed, expected);
  EXPECT_GT(result.p_value, level) << "statistic " << result.statistic << " with "
                                   << result.degrees_of_freedom << " degrees of freedom";
  return static_cast<double>(failed) / kEvenSamples;
}

}  // namespace tessera::test
