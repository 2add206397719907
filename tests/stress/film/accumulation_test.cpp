// Sums of very many samples: through the sum tree of a tile, and through the client's merging of nodes.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "image/assemble.h"
#include "render/film/tile_accumulator.h"
#include "support/long_form.h"
#include "wire/aov_channels.h"
#include "wire/limits.h"

namespace tessera::render {
namespace {

/// A sum in double with the part that each addition loses [Neumaier 1974]: 2^30 terms to the last bits of a
/// double.
class ExactSum {
 public:
  void add(double x) {
    const double sum = sum_ + x;
    lost_ += std::abs(sum_) >= std::abs(x) ? (sum_ - sum) + x : (x - sum) + sum_;
    sum_ = sum;
  }
  double value() const { return sum_ + lost_; }

 private:
  double sum_ = 0, lost_ = 0;
};

std::uint32_t hashed(std::uint64_t x) {
  x = (x ^ (x >> 31)) * 0x7fb5d329728ea185u;
  x = (x ^ (x >> 27)) * 0x81dadef4bc2dd44du;
  return static_cast<std::uint32_t>((x ^ (x >> 33)) >> 16);
}

/// Values that a pixel's samples may have; a function of the sample's number.
struct Stream {
  const char* name;
  float (*value)(std::uint64_t i);
};
const Stream kStreams[] = {
    {"a constant with all digits", [](std::uint64_t) { return 0.1f; }},
    {"noise", [](std::uint64_t i) { return static_cast<float>(hashed(i)) * 0x1p-32f; }},
    // Black but for a firefly in 4096.
    {"fireflies",
     [](std::uint64_t i) {
       return hashed(i) < 1u << 20 ? 1e4f * (1 + static_cast<float>(hashed(i + 7) >> 8) * 0x1p-24f) : 0.0f;
     }},
    // Twelve orders of magnitude, evenly in the logarithm.
    {"all magnitudes",
     [](std::uint64_t i) { return std::exp2(static_cast<float>(hashed(i)) * 0x1p-32f * 40 - 20); }},
    // A bright beginning, then samples below half a unit in the last place of a running sum of floats: that
    // stands still.
    {"a bright start", [](std::uint64_t i) { return i < 1024 ? 1e3f : 1e-3f; }},
};

// Every value takes part in at most 30 additions, each right to half a unit in the last place: 30 * 2^-24
// = 1.8e-6 at the very worst, when all round the same way. Roundings of different additions are independent,
// or, for a constant, made again by both halves: what is seen is below sqrt(30) * 2^-24 = 3.3e-7.
constexpr double kSumTolerance = 1e-6;

/// One pixel, all samples through one accumulator.
TEST(Accumulation, OfOnePixelsSumTree) {
  const std::uint32_t samples = test::long_form() ? 1'000'000'000 : 5'000'000;
  for (const Stream& stream : kStreams) {
    wire::TileResult result;
    result.x1 = result.y1 = 1;
    result.sample_end = samples;
    result.channels = {{"R", wire::ChannelKind::kSum, 0}};
    TileAccumulator film(result);
    const std::uint32_t pixel = 0;
    film.begin_pixels({&pixel, 1});
    ExactSum exact;
    for (std::uint32_t i = 0; i < samples; ++i) {
      const float value = stream.value(i);
      film.add_sample(&value, 1);
      exact.add(value);
    }
    film.end_pixels();
    EXPECT_EQ(result.counts[0], samples);
    EXPECT_NEAR(result.values[0], exact.value(), kSumTolerance * exact.value()) << stream.name;
    std::printf("%s: off by %.1e of the sum of %u\n", stream.name, result.values[0] / exact.value() - 1,
                samples);
  }
}

/// Units of a job as workers make them, merged by the client as they come in: out of order. Sums and
/// deviations.
TEST(Accumulation, OfUnitsOnTheClient) {
  constexpr std::uint32_t kUnits = 64;
  const std::uint32_t side = test::long_form() ? 8 : 4,
                      spp = test::long_form() ? wire::kMaxSamplesPerPixel : 1u << 16;
  const std::uint32_t pixels = side * side, unit = spp / kUnits;
  client::AssemblyOptions options;
  options.width = options.height = side;
  options.crop = {0, 0, static_cast<std::int32_t>(side), static_cast<std::int32_t>(side)};
  options.spp = spp;
  options.channels = wire::channels_for_aovs({v1::AOV_VARIANCE});
  auto assembler = client::Assembler::create(options);
  ASSERT_TRUE(assembler.ok()) << assembler.status();

  const Stream& noise = kStreams[1];
  std::vector<ExactSum> sums(pixels), squares(pixels);
  std::vector<std::uint32_t> all(pixels);
  for (std::uint32_t p = 0; p < pixels; ++p) all[p] = p;
  std::vector<float> planes(4 * pixels, 1.0f);
  for (std::uint32_t k = 0; k < kUnits; ++k) {
    const std::uint32_t begin =
        (k * 37 + 11) % kUnits * unit;  // 37 and 64 have no common factor: every unit once
    wire::TileResult result;
    result.x1 = result.y1 = side;
    result.sample_begin = begin;
    result.sample_end = begin + unit;
    result.channels = options.channels;
    TileAccumulator film(result);
    film.begin_pixels(all);
    for (std::uint32_t i = begin; i < begin + unit; ++i) {
      for (std::uint32_t p = 0; p < pixels; ++p) {
        const float value = noise.value(std::uint64_t{p} << 32 | i);
        planes[p] = planes[pixels + p] = planes[2 * pixels + p] = value;
        sums[p].add(value);
        squares[p].add(double{value} * value);
      }
      film.add_sample(planes.data(), pixels);
    }
    film.end_pixels();
    ASSERT_TRUE(assembler->add(std::move(result)).ok());
  }
  ASSERT_TRUE(assembler->complete());
  const auto assembly = std::move(*assembler).finish();
  ASSERT_TRUE(assembly.ok()) << assembly.status();
  const client::Image& image = assembly->image;
  const client::Channel* red = image.find("R");
  const client::Channel* variance = image.find("variance.R");
  ASSERT_TRUE(red != nullptr && variance != nullptr);
  for (std::uint32_t p = 0; p < pixels; ++p) {
    const double mean = sums[p].value() / spp;
    EXPECT_NEAR(red->values[p], mean, kSumTolerance * mean) << p;
    // Deviations are merged in double and rounded once a level; the means that they look at are floats, whose
    // errors count by their squares.
    const double expected = (squares[p].value() - spp * mean * mean) / (spp - 1);
    EXPECT_NEAR(variance->values[p], expected, 2 * kSumTolerance * expected) << p;
  }
}

}  // namespace
}  // namespace tessera::render
