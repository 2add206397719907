#include "render/sampling/sample_key.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <span>
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

/// A (0, m, 2)-net in base 2: each elementary interval of area 2^-m holds exactly one of 2^m points.
void expect_net(std::span<const Pair> points, int m) {
  ASSERT_EQ(points.size(), std::size_t{1} << m);
  for (int a = 0; a <= m; ++a) {
    std::set<std::pair<int, int>> cells;
    for (const auto& [u, v] : points) {
      cells.emplace(static_cast<int>(u * static_cast<float>(1 << a)),
                    static_cast<int>(v * static_cast<float>(1 << (m - a))));
    }
    EXPECT_EQ(cells.size(), points.size()) << "m " << m << " a " << a;
  }
}

TEST(SobolSampler, EveryAlignedPowerOfTwoRunIsANet) {
  // Owen scrambling and shuffling keep that for every aligned run of the sequence.
  const std::vector<Pair> points = samples(SamplerKind::kSobol, 17, 5, 3, 256);
  for (const int m : {4, 5, 6, 8}) {
    const std::size_t run = std::size_t{1} << m;
    for (std::size_t first = 0; first < 256; first += run)
      expect_net(std::span(points).subspan(first, run), m);
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

TEST(ZSobolSampler, PixelsAndAlignedBlocksOfThemAreNets) {
  constexpr std::uint32_t kSampleBits = 4;
  for (const int dimension : {0, 3, 70}) {
    for (const int side_bits : {0, 1, 2}) {  // a block's side; squares of sequences have 2^8 pixels a side
      for (const std::uint32_t x0 : {0u, 256u - 4u, 256u}) {
        std::vector<Pair> points;
        for (std::uint32_t p = 0; p < 1u << (2 * side_bits); ++p) {
          const UInt x(x0 + (p & ((1u << side_bits) - 1))), y(512 + (p >> side_bits));
          const SampleKey key = sample_key(
              {.kind = SamplerKind::kZSobol, .seed = 7, .sample_bits = kSampleBits}, x, y, UInt::iota(0));
          const Vec2 u = Sampler(SamplerKind::kZSobol, key.pixel, key.reversed_sample).get_2d(dimension);
          for (int l = 0; l < kWidth; ++l) points.emplace_back(u.x.lane(l), u.y.lane(l));
        }
        expect_net(points, static_cast<int>(kSampleBits) + 2 * side_bits);
      }
    }
  }
}

TEST(ZSobolSampler, HasRoomForAllSamplesOfAPixel) {
  // 2^24 samples leave room for 16 x 16 pixels: each has numbers of its own, also from those of other
  // squares.
  std::set<std::pair<std::uint32_t, std::uint32_t>> keys;
  constexpr std::uint32_t kLast = (1u << 24) - kWidth;
  for (std::uint32_t x = 0; x < 40; ++x) {
    for (const std::uint32_t first : {0u, kLast}) {
      const SampleKey key = sample_key({.kind = SamplerKind::kZSobol, .seed = 7, .sample_bits = 24}, UInt(x),
                                       UInt(3u), UInt::iota(first));
      for (int l = 0; l < kWidth; ++l) keys.emplace(key.pixel.lane(l), key.reversed_sample.lane(l));
    }
  }
  EXPECT_EQ(keys.size(), 40u * 2 * kWidth);
}

/// Numbers `first` .. first + count - 1 of the 16 pixels of a group: pixel m's number first + i at 16 i + m.
std::vector<Pair> of_group(int dimension, std::uint32_t first, std::uint32_t count, std::uint32_t x = 17) {
  static_assert(kGroupSize == kWidth);
  std::vector<Pair> points;
  const UInt key = Sampler::group_key(Sampler::pixel_hash(3, UInt(x), UInt(5u)), UInt::iota(0));
  for (std::uint32_t number = first; number < first + count; ++number) {
    const Vec2 u = Sampler(SamplerKind::kGroupSobol, key, reverse_bits(UInt(number))).get_2d(dimension);
    for (int l = 0; l < kWidth; ++l) points.emplace_back(u.x.lane(l), u.y.lane(l));
  }
  return points;
}

TEST(GroupSobolSampler, SamplesOfOneNumberAndOfTheFirstNumbersAreNets) {
  for (const int dimension : {0, 3, 70}) {
    const std::vector<Pair> points = of_group(dimension, 0, 256);
    for (std::size_t number = 0; number < 256; ++number)
      expect_net(std::span(points).subspan(16 * number, 16), 4);
    for (int m = 5; m <= 12; ++m) expect_net(std::span(points).first(std::size_t{1} << m), m);
  }
}

TEST(GroupSobolSampler, EveryAlignedPowerOfTwoRunOfAPixelIsANet) {
  for (const std::uint32_t first : {0u, 1u << 12, 1u << 23}) {
    constexpr std::uint32_t kNumbers = 4096;
    const std::vector<Pair> points = of_group(3, first, kNumbers);
    for (std::size_t member = 0; member < 16; ++member) {
      std::vector<Pair> own;
      for (std::size_t i = 0; i < kNumbers; ++i) own.push_back(points[16 * i + member]);
      for (const int m : {1, 2, 4, 5, 8, 12}) {
        const std::size_t run = std::size_t{1} << m;
        for (std::size_t at = 0; at < kNumbers; at += run) expect_net(std::span(own).subspan(at, run), m);
      }
    }
  }
}

/// Halves that points of one number lie in, in two pairs of dimensions: as often the same as not, and by
/// chance.
TEST(GroupSobolSampler, PairsOfDimensionsArePairedByChance) {
  constexpr int kGroups = 256;
  double squares = 0;
  for (std::uint32_t group = 0; group < kGroups; ++group) {
    const std::vector<Pair> a = of_group(1, 5, 1, group), b = of_group(6, 5, 1, group);
    int same = 0;
    for (std::size_t m = 0; m < 16; ++m) same += (a[m].first < 0.5f) == (b[m].first < 0.5f) ? 1 : 0;
    squares += (same - 8) * (same - 8);
  }
  // Eight bits are drawn for two points each; 64 if halves of one pair told those of the other.
  EXPECT_NEAR(squares / kGroups, 8, 4);
}

/// Dimensions of one pixel, and of two of its group, are independent: means over groups of u v, in standard
/// deviations.
TEST(GroupSobolSampler, OneSampleIsUniformOverGroups) {
  constexpr std::uint32_t kGroups = 4096;
  double sums[2][2]{};
  for (std::uint32_t group = 0; group < kGroups; ++group) {
    const std::vector<Pair> a = of_group(1, 5, 1, group), b = of_group(6, 5, 1, group);
    sums[0][0] += double{a[3].first} * a[3].second, sums[0][1] += double{a[3].first} * b[3].second;
    sums[1][0] += double{a[3].first} * b[9].second, sums[1][1] += double{a[12].first} * b[12].first;
  }
  // |z| > 4.5 has probability 7e-6; the seed is fixed.
  for (const auto& two : sums) {
    for (const double sum : two)
      EXPECT_LT(std::abs(sum / kGroups - 0.25) / std::sqrt(7.0 / 144 / kGroups), 4.5);
  }
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
