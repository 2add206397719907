#include "render/sampling/sampler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <utility>
#include <vector>

namespace tessera::render::TESSERA_ISA {
namespace {

using Pair = std::pair<float, float>;

/// The pairs of samples 0 .. n-1 (a multiple of 16) of one pixel and dimension.
std::vector<Pair> samples(SamplerKind kind, std::uint32_t x, std::uint32_t y, int dimension, int n,
                          std::uint64_t seed = 0) {
  std::vector<Pair> result;
  for (int first = 0; first < n; first += kWidth) {
    const UInt index = UInt::iota(static_cast<std::uint32_t>(first));
    const Sampler sampler(kind, Sampler::pixel_hash(seed, UInt(x), UInt(y)), reverse_bits(index));
    const Vec2 u = sampler.get_2d(dimension);
    for (int i = 0; i < kWidth; ++i) result.emplace_back(u.x.lane(i), u.y.lane(i));
  }
  return result;
}

TEST(SobolSampler, EveryAlignedPowerOfTwoRunIsANet) {
  // A (0, m, 2)-net in base 2: each elementary interval of area 2^-m holds exactly one of 2^m points. Owen
  // scrambling and shuffling keep that for every aligned run of the sequence.
  const std::vector<Pair> points = samples(SamplerKind::kSobol, 17, 5, 3, 256);
  for (const int m : {4, 5, 6, 8}) {
    const int run = 1 << m;
    for (int first = 0; first < 256; first += run) {
      for (int a = 0; a <= m; ++a) {
        std::set<std::pair<int, int>> cells;
        for (int i = first; i < first + run; ++i) {
          const auto& [u, v] = points[static_cast<std::size_t>(i)];
          cells.emplace(static_cast<int>(u * static_cast<float>(1 << a)),
                        static_cast<int>(v * static_cast<float>(1 << (m - a))));
        }
        EXPECT_EQ(cells.size(), static_cast<std::size_t>(run))
            << "m " << m << " first " << first << " a " << a;
      }
    }
  }
}

TEST(SobolSampler, PixelsDimensionsAndSeedsDiffer) {
  const auto base = samples(SamplerKind::kSobol, 3, 4, 0, 16);
  EXPECT_NE(base, samples(SamplerKind::kSobol, 4, 3, 0, 16));
  EXPECT_NE(base, samples(SamplerKind::kSobol, 3, 4, 1, 16));
  EXPECT_NE(base, samples(SamplerKind::kSobol, 3, 4, 0, 16, 1));
  EXPECT_NE(base, samples(SamplerKind::kSobol, 3, 4, 0, 16, std::uint64_t{1} << 32));
  EXPECT_EQ(base, samples(SamplerKind::kSobol, 3, 4, 0, 16));
}

/// Mean of u v over pixels minus 1/4, in standard deviations: 7/144 is the variance of u v for independent u
/// and v.
double product_z(SamplerKind kind, int dimension_a, int dimension_b) {
  double sum = 0;
  constexpr int kPixels = 4096;
  for (std::uint32_t p = 0; p < kPixels; ++p) {
    const auto a = samples(kind, p % 64, p / 64, dimension_a, 16),
               b = samples(kind, p % 64, p / 64, dimension_b, 16);
    sum += double{a[5].first} * b[5].second;
  }
  return (sum / kPixels - 0.25) / std::sqrt(7.0 / 144 / kPixels);
}

TEST(Samplers, OneSampleIsUniformOverPixels) {
  for (const SamplerKind kind : {SamplerKind::kSobol, SamplerKind::kIndependent}) {
    // |z| > 4.5 has probability 7e-6; seeds are fixed.
    EXPECT_LT(std::abs(product_z(kind, 0, 0)), 4.5);
    EXPECT_LT(std::abs(product_z(kind, 1, 6)), 4.5);
  }
}

TEST(IndependentSampler, CoversTheSquare) {
  // Chi-square of 16 x 16 cells with 16 expected in each: 255 degrees of freedom, 1 - 1e-5 quantile 356.
  const auto points = samples(SamplerKind::kIndependent, 9, 9, 2, 4096);
  std::vector<int> cells(256, 0);
  for (const auto& [u, v] : points)
    ++cells[static_cast<std::size_t>(static_cast<int>(u * 16) * 16 + static_cast<int>(v * 16))];
  double chi2 = 0;
  for (const int n : cells) chi2 += (n - 16.0) * (n - 16.0) / 16;
  EXPECT_LT(chi2, 356);
  EXPECT_GT(chi2, 170);  // too even would be a grid, not independent samples (1e-5 quantile 171)
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
