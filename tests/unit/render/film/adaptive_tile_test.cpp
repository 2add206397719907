#include "render/film/adaptive_tile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "render/film/noise_target.h"
#include "wire/aov_channels.h"

namespace tessera::render {
namespace {

/// Value of a pixel's sample, the same in R, G and B.
using Shade = std::function<float(const SampleName&)>;

/// A number in [0, 1) that depends on the sample's name alone (the finisher of splitmix64).
double uniform(const SampleName& name, std::uint64_t seed = 0) {
  std::uint64_t x = (std::uint64_t{name.x} << 48) ^ (std::uint64_t{name.y} << 32) ^
                    (std::uint64_t{name.stream} << 31) ^ name.index ^ (seed << 12);
  for (int round = 0; round < 2; ++round) {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    x ^= x >> 31;
  }
  return static_cast<double>(x >> 11) * 0x1p-53;
}

struct Rect {
  std::uint32_t x0, y0, x1, y1;
};

wire::TileResult render(const Rect& rect, std::uint32_t width, std::uint32_t height,
                        const NoiseTarget& target, const Shade& shade, std::size_t batch = 1024) {
  wire::TileResult result;
  result.x0 = rect.x0, result.y0 = rect.y0, result.x1 = rect.x1, result.y1 = rect.y1;
  result.sample_end = target.samples;
  result.channels = wire::channels_for_aovs({v1::AOV_VARIANCE, v1::AOV_DEPTH});
  AdaptiveTile film(result, width, height, target);
  std::vector<SampleName> names(batch);
  std::vector<float> planes(5 * batch);  // R, G, B, A, depth
  while (const std::size_t count = film.next(names)) {
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_TRUE(names[i].x < width && names[i].y < height && names[i].stream < 2);
      EXPECT_LT(names[i].index, std::max(target.samples / 2, kPilotSamples));
      const float value = shade(names[i]);
      for (std::size_t c = 0; c < 3; ++c) planes[c * batch + i] = value;
      planes[3 * batch + i] = 1;
      planes[4 * batch + i] = static_cast<float>(names[i].x);
    }
    film.add(std::span(names).first(count), planes.data(), batch);
  }
  return result;
}

/// Quiet on the left, noisy on the right.
float uneven(const SampleName& name) { return static_cast<float>(1 + (uniform(name) - 0.5) * name.x / 16.0); }

TEST(AdaptiveTile, TheSameBitsInEveryTileCropAndBatch) {
  constexpr std::uint32_t kWidth = 44, kHeight = 27;  // blocks cut by the film's border
  const NoiseTarget target{.noise = 0.05, .samples = 200};
  const wire::TileResult whole = render({0, 0, kWidth, kHeight}, kWidth, kHeight, target, uneven);
  std::uint32_t fewest = ~0u, most = 0;
  for (const std::uint32_t count : whole.counts)
    fewest = std::min(fewest, count), most = std::max(most, count);
  EXPECT_EQ(fewest, 2 * kPilotSamples);
  EXPECT_GT(most, 3 * fewest) << "nothing was decided";

  const std::vector<std::pair<Rect, std::size_t>> parts = {{{0, 0, 8, 8}, 1024},
                                                           {{40, 24, 44, 27}, 7},
                                                           {{16, 8, 40, 24}, 100},
                                                           {{3, 5, 43, 26}, 1024},
                                                           {{33, 17, 34, 18}, 64}};
  for (const auto& [rect, batch] : parts) {
    const wire::TileResult part = render(rect, kWidth, kHeight, target, uneven, batch);
    for (std::uint32_t y = rect.y0; y < rect.y1; ++y) {
      for (std::uint32_t x = rect.x0; x < rect.x1; ++x) {
        const std::size_t at = (y - rect.y0) * (rect.x1 - rect.x0) + x - rect.x0, of = y * kWidth + x;
        EXPECT_EQ(part.counts[at], whole.counts[of]) << x << ", " << y;
        for (std::size_t c = 0; c < part.channels.size(); ++c) {
          EXPECT_EQ(std::bit_cast<std::uint32_t>(part.values[c * part.pixel_count() + at]),
                    std::bit_cast<std::uint32_t>(whole.values[c * whole.pixel_count() + of]))
              << x << ", " << y << ", " << part.channels[c].name;
        }
      }
    }
  }
}

TEST(AdaptiveTile, WhatDoesNotVaryTakesThePilotAndIsExact) {
  const NoiseTarget target{.noise = 0.01, .samples = 4096};
  const wire::TileResult tile = render({8, 0, 24, 8}, 64, 64, target,
                                       [](const SampleName& name) { return name.x < 16 ? 0.0f : 3.25f; });
  for (std::size_t i = 0; i < tile.pixel_count(); ++i) {
    EXPECT_EQ(tile.counts[i], 2 * kPilotSamples);
    EXPECT_EQ(tile.values[i], i % 16 < 8 ? 0.0f : 3.25f * 2 * kPilotSamples);
    EXPECT_EQ(tile.values[4 * tile.pixel_count() + i], 0.0f) << "variance.R";
    EXPECT_EQ(tile.values[7 * tile.pixel_count() + i], static_cast<float>(8 + i % 16) * 2 * kPilotSamples)
        << "depth";
  }
}

TEST(AdaptiveTile, TakesNoMoreThanTheCap) {
  for (const std::uint32_t samples : {16u, 17u, 31u, 100u}) {
    const wire::TileResult tile = render({0, 0, 8, 8}, 8, 8, {.noise = 1e-4, .samples = samples}, uneven);
    for (const std::uint32_t count : tile.counts) EXPECT_EQ(count, samples / 2 * 2);
  }
}

TEST(AdaptiveTile, VarianceOverSamplesIsTheErrorOfThePixel) {
  // Where both halves decide differently, the pixel's error is above the variance of samples over their
  // number: it is said to be so. Many renders of one block, against what they scatter by.
  const NoiseTarget target{.noise = 0.1, .samples = 256};
  constexpr int kRenders = 400;
  double said = 0, squares = 0;
  for (int i = 0; i < kRenders; ++i) {
    const wire::TileResult tile = render({0, 0, 8, 8}, 8, 8, target, [&](const SampleName& name) {
      return static_cast<float>(uniform(name, static_cast<std::uint64_t>(i) + 1) < 0.2 ? 5 : 0);
    });
    for (std::size_t p = 0; p < 64; ++p) {
      const double count = tile.counts[p], error = tile.values[p] / count - 1;
      said += tile.values[4 * 64 + p] / (count - 1) / count;
      squares += error * error;
    }
  }
  // 25,600 squares of errors that are nearly normal: 1 % each way, four times.
  EXPECT_NEAR(said / squares, 1, 0.04);
}

// ---------------------------------------------------------------- bias

/// Paths that are bright once in a thousand: most pilots see none of them, and one that does sees too many.
constexpr double kRare = 1e-3;
const NoiseTarget kRareTarget{.noise = 0.1, .samples = 128};

/// The mean of many blocks whose true mean is 1, and its standard error.
std::pair<double, double> mean_of_blocks(bool one_stream) {
  double sum = 0, squares = 0;
  constexpr int kBlocks = 20'000, kColumns = 8;
  for (int i = 0; i < kBlocks / kColumns; ++i) {
    const wire::TileResult tile =
        render({0, 0, 8 * kColumns, 8}, 8 * kColumns, 8, kRareTarget, [&](SampleName name) {
          if (one_stream) name.stream = 0;
          return static_cast<float>(uniform(name, static_cast<std::uint64_t>(i) + 1) < kRare ? 1 / kRare : 0);
        });
    for (std::size_t block = 0; block < kColumns; ++block) {
      double mean = 0;
      for (std::size_t p = 0; p < 64; ++p) {
        const std::size_t at = p / 8 * 8 * kColumns + 8 * block + p % 8;
        mean += tile.values[at] / static_cast<double>(tile.counts[at]) / 64;
      }
      sum += mean;
      squares += mean * mean;
    }
  }
  const double mean = sum / kBlocks;
  return {mean, std::sqrt((squares / kBlocks - mean * mean) / kBlocks)};
}

TEST(AdaptiveTile, RareBrightPathsKeepTheirLight) {
  const auto [mean, error] = mean_of_blocks(/*one_stream=*/false);
  EXPECT_LT(error, 0.02);
  // One in 16,000 seeds.
  EXPECT_NEAR(mean, 1, 4 * error);
}

TEST(AdaptiveTile, TheTestOfBiasSeesBias) {
  // With one stream for both halves, each half decides on its own samples: sampling stops where no light
  // came.
  const auto [mean, error] = mean_of_blocks(/*one_stream=*/true);
  EXPECT_LT(mean, 1 - 20 * error);
  EXPECT_LT(mean, 0.7);
}

/// A block of `kRare` paths again, by the numbers of bright samples alone, so that a bias of 0.1 % is seen.
/// `crossed`: the rule; otherwise a half decides on itself, as renderers do that stop at their own noise.
std::pair<double, double> mean_by_numbers(bool crossed) {
  std::mt19937_64 random(1);
  constexpr int kBlocks = 12'000'000, kPixels = 64;
  std::binomial_distribution<int> pilot(kPixels * kPilotSamples, kRare);
  const std::uint32_t most = kRareTarget.samples / 2;
  // Count that follows from k bright pilot samples, all in different pixels (AdaptiveTile::pilot_error).
  std::vector<std::uint32_t> count_for;
  for (int k = 0; k < 64; ++k) {
    const double samples = kPixels * kPilotSamples, mean = k / kRare / samples;
    count_for.push_back(
        samples_for(kRareTarget, k / (kRare * kRare) / (samples * kPilotSamples) / (mean * mean + 0.01)));
  }
  std::vector<std::binomial_distribution<int>> rest;
  for (std::uint32_t count = 0; count <= most; ++count) {
    rest.emplace_back(kPixels * static_cast<int>(std::max(count, kPilotSamples) - kPilotSamples), kRare);
  }
  double sum = 0, squares = 0;
  for (int i = 0; i < kBlocks; ++i) {
    const int seen[2] = {pilot(random), pilot(random)};
    double mean = 0;
    for (int half = 0; half < 2; ++half) {
      const std::uint32_t count = count_for[static_cast<std::size_t>(seen[crossed ? 1 - half : half])];
      mean += 0.5 * (seen[half] + rest[count](random)) / (kRare * kPixels * count);
    }
    sum += mean;
    squares += mean * mean;
  }
  const double mean = sum / kBlocks;
  return {mean, std::sqrt((squares / kBlocks - mean * mean) / kBlocks)};
}

TEST(NoiseTarget, RareBrightPathsAreNotBiasedByATenthOfAPercent) {
  const auto [mean, error] = mean_by_numbers(/*crossed=*/true);
  EXPECT_LT(error, 4e-4);
  EXPECT_NEAR(mean, 1, 1e-3 + 2 * error);
  RecordProperty("bias_percent", std::to_string(100 * (mean - 1)));
}

TEST(NoiseTarget, StoppingAtOnesOwnNoiseIsBiased) {
  const auto [mean, error] = mean_by_numbers(/*crossed=*/false);
  EXPECT_LT(mean, 0.9);
  RecordProperty("bias_percent", std::to_string(100 * (mean - 1)));
}

TEST(NoiseTarget, MoreSamplesForLessNoiseAndMoreDeviation) {
  const NoiseTarget target{.noise = 0.02, .samples = 1 << 20};
  std::uint32_t last = 0;
  for (double error = 0; error < 10; error += 0.01) {
    const std::uint32_t count = samples_for(target, error);
    EXPECT_GE(count, last);
    EXPECT_GE(count, kPilotSamples);
    EXPECT_LE(samples_for({.noise = 0.04, .samples = 1 << 20}, error), count);
    last = count;
  }
  // Samples that deviate by a third of their mean, 278 of them, have an error of 2 %; steps are of half at
  // most.
  const std::uint32_t usual = 2 * samples_for(target, 1.0 / 9 / kPilotSamples);
  EXPECT_GE(usual, 277u);
  EXPECT_LE(usual, 417u);
}

TEST(NoiseTarget, WhateverThePilotSawIsAnAnswer) {
  const NoiseTarget target{.noise = 0.02, .samples = 256};
  EXPECT_EQ(samples_for(target, 0), kPilotSamples);
  EXPECT_EQ(samples_for(target, 1e300), 128u);
  EXPECT_EQ(samples_for(target, INFINITY), 128u);
  EXPECT_EQ(samples_for(target, NAN), 128u);
}

}  // namespace
}  // namespace tessera::render
