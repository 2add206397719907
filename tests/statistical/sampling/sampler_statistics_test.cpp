// Are the samplers' numbers uniform, in every dimension and in pairs of them, within a pixel and from pixel
// to pixel?
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "render/sampling/sample_key.h"
#include "render/transport/vertex/dimensions.h"
#include "support/kernel/chi2.h"

namespace tessera::render::TESSERA_ISA {
namespace {

constexpr SamplerKind kKinds[] = {SamplerKind::kSobol, SamplerKind::kIndependent, SamplerKind::kZSobol};

/// Dimensions as the integrators use them: those of the camera, of early and late bounces, of media.
constexpr int kPairs[] = {
    0, 1, 2, 3, 4, 6, 7, 4 * 16 + 3, dimension::kFlight, dimension::kFlight + 1, dimension::kOpacity};

/// One coordinate of a sample: of pair kPairs[pair], the first or the second number.
struct Coordinate {
  int pair;
  bool second;
};
std::vector<Coordinate> coordinates() {
  std::vector<Coordinate> all;
  for (const int pair : kPairs) all.insert(all.end(), {{pair, false}, {pair, true}});
  return all;
}

/// 16 samples of 16 pixels, or of one.
struct Places {
  UInt x, y, sample;
};
Float number(SamplerKind kind, std::uint64_t seed, const Places& at, Coordinate c) {
  const SampleKey key = sample_key({.kind = kind, .seed = seed, .sample_bits = 11}, at.x, at.y, at.sample);
  const Sampler sampler(kind, key.pixel, key.reversed_sample);
  const Vec2 u = sampler.get_2d(c.pair);
  return c.second ? u.y : u.x;
}

/// 16 neighbouring pixels of a film 256 wide, the same sample of each.
Places row_of_pixels(std::uint32_t first, std::uint32_t sample) {
  const UInt pixel = UInt::iota(first);
  return {pixel & 255u, shift_right<8>(pixel), UInt(sample)};
}

/// Pixels or samples that a statistic looks at.
constexpr std::uint32_t kCount = 1 << 16;

/// Chi-square of pairs of numbers against the uniform density of the square.
double p_of_square(const std::function<void(std::uint32_t first, Float& u, Float& v)>& numbers) {
  constexpr int kSide = 32;
  std::vector<double> observed(kSide * kSide), expected(kSide * kSide, double{kCount} / (kSide * kSide));
  for (std::uint32_t first = 0; first < kCount; first += kWidth) {
    Float u, v;
    numbers(first, u, v);
    for (int l = 0; l < kWidth; ++l) {
      const int column = static_cast<int>(u.lane(l) * kSide), row = static_cast<int>(v.lane(l) * kSide);
      ++observed[static_cast<std::size_t>(row * kSide + column)];
    }
  }
  return test::chi_square_test(observed, expected).p_value;
}

TEST(SamplerStatistics, NumbersLieInTheUnitInterval) {
  for (const SamplerKind kind : kKinds) {
    for (const Coordinate c : coordinates()) {
      float least = 1, most = 0;
      for (std::uint32_t first = 0; first < kCount; first += kWidth) {
        const Float u = number(kind, 3, row_of_pixels(first, 5), c);
        for (int l = 0; l < kWidth; ++l) least = std::min(least, u.lane(l)), most = std::max(most, u.lane(l));
      }
      EXPECT_GE(least, 0);
      EXPECT_LT(most, 1);
      // All of 2^16 uniform numbers stay out of the lowest 2 / 10^4 once in 5 * 10^5.
      EXPECT_LT(least, 2e-4f);
      EXPECT_GT(most, 1 - 2e-4f);
    }
  }
}

/// The same sample of many pixels, each coordinate against each: what a picture's error looks like from pixel
/// to pixel.
TEST(SamplerStatistics, PairsOfDimensionsAreUniformOverPixels) {
  const std::vector<Coordinate> all = coordinates();
  const int tests = static_cast<int>(std::size(kKinds) * all.size() * (all.size() - 1) / 2);
  for (const SamplerKind kind : kKinds) {
    for (std::size_t a = 0; a < all.size(); ++a) {
      for (std::size_t b = a + 1; b < all.size(); ++b) {
        const double p = p_of_square([&](std::uint32_t first, Float& u, Float& v) {
          const Places at = row_of_pixels(first, 6);
          u = number(kind, 1, at, all[a]);
          v = number(kind, 1, at, all[b]);
        });
        EXPECT_GT(p, test::sidak_level(0.01, tests))
            << static_cast<int>(kind) << ": " << all[a].pair << ' ' << all[b].pair;
      }
    }
  }
}

/// Each dimension of a pixel against the same one of a neighbour, of the next sample, of another seed.
TEST(SamplerStatistics, NeighboursSamplesAndSeedsAreIndependent) {
  struct Other {
    const char* what;
    std::uint32_t dx, dy, dsample;
    std::uint64_t seed;
  };
  // The integrators' first sample is 0; a job's seeds are often small and next to each other.
  const Other others[] = {{"the pixel to the right", 1, 0, 0, 1},
                          {"the pixel below", 0, 1, 0, 1},
                          {"a pixel of the next tile", 64, 0, 0, 1},
                          {"the next sample", 0, 0, 1, 1},
                          {"sample 1024", 0, 0, 1024, 1},
                          {"the next seed", 0, 0, 0, 2},
                          {"a seed of 64 bits", 0, 0, 0, std::uint64_t{1} << 32 | 1}};
  const std::vector<Coordinate> all = coordinates();
  const int tests = static_cast<int>(std::size(kKinds) * all.size() * std::size(others));
  for (const SamplerKind kind : kKinds) {
    for (const Other& other : others) {
      // Sobol' samples of one pixel keep out of each other's way, and are meant to.
      if (kind != SamplerKind::kIndependent && other.dsample != 0) continue;
      for (const Coordinate c : all) {
        const double p = p_of_square([&](std::uint32_t first, Float& u, Float& v) {
          const Places at = row_of_pixels(first, 0);
          u = number(kind, 1, at, c);
          v = number(kind, other.seed, {at.x + other.dx, at.y + other.dy, at.sample + other.dsample}, c);
        });
        EXPECT_GT(p, test::sidak_level(0.01, tests))
            << static_cast<int>(kind) << ": " << other.what << ", pair " << c.pair;
      }
    }
  }
}

/// All samples of one pixel. Sobol' numbers are more even than chance: each of the 32 x 32 cells has its
/// share to one.
TEST(SamplerStatistics, SamplesOfAPixelFillTheSquare) {
  for (const int pair : kPairs) {
    const auto of_one_pixel = [pair](SamplerKind kind) {
      return p_of_square([&](std::uint32_t first, Float& u, Float& v) {
        const Places at{UInt(7u), UInt(11u), UInt::iota(first)};
        u = number(kind, 1, at, {pair, false});
        v = number(kind, 1, at, {pair, true});
      });
    };
    EXPECT_GT(of_one_pixel(SamplerKind::kIndependent), test::sidak_level(0.01, std::size(kPairs))) << pair;
    // A statistic of 0: the probability that independent samples would do worse is 1.
    EXPECT_EQ(of_one_pixel(SamplerKind::kSobol), 1) << pair;
  }
}

/// Different pairs of dimensions within a pixel are padded, not jointly stratified: they must at least be
/// uniform together. A sample's numbers in two pairs come from one shuffled index each; an unlucky hash would
/// tie them together.
TEST(SamplerStatistics, PairsWithinAPixelAreUnrelated) {
  constexpr std::uint32_t kPixels = 64;
  const std::vector<Coordinate> all = coordinates();
  int bad = 0, tests = 0;
  for (std::uint32_t p = 0; p < kPixels; ++p) {
    for (std::size_t a = 0; a + 2 < all.size(); a += 2, ++tests) {
      constexpr std::uint32_t kSamples = 1024;
      double sum = 0;
      for (std::uint32_t first = 0; first < kSamples; first += kWidth) {
        const Places at{UInt(p * 5), UInt(p * 3 + 1), UInt::iota(first)};
        const Float u = number(SamplerKind::kSobol, 9, at, all[a]),
                    v = number(SamplerKind::kSobol, 9, at, all[a + 2]);
        for (int l = 0; l < kWidth; ++l) sum += (u.lane(l) - 0.5) * (v.lane(l) - 0.5);
      }
      // The product of independent uniform numbers has the variance 1/144; four standard errors are crossed
      // once in 16,000.
      bad += std::abs(sum / kSamples) > 4.0 / 12 / std::sqrt(double{kSamples});
    }
  }
  // 640 tests: 0.04 expected; three by chance once in 10^5.
  EXPECT_LT(bad, 3) << "of " << tests;
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
