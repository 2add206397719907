#include "image/metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "image/exr.h"
#include "support/needs.h"

namespace tessera::client {
namespace {

using ::testing::HasSubstr;

// Multiples of 2^-24 in [0, 1) from a linear congruential generator: the same in every language.
Image noise(std::uint32_t seed, int width, int height) {
  Image image;
  image.data = image.display = {0, 0, width, height};
  for (const char* name : {"R", "G", "B"}) {
    for (float& value : image.add(name).values) {
      seed = seed * 1664525 + 1013904223;
      value = static_cast<float>(seed >> 8) / 16777216.0f;
    }
  }
  return image;
}

// A noisy version of noise(1) with a shifted block and a pixel that is not a number.
Image disturbed(const Image& reference) {
  Image image = noise(2, reference.data.width(), reference.data.height());
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < image.pixel_count(); ++i) {
      float& value = image.channels[c].values[i];
      value = (value - 0.5f) * 0.0625f + reference.channels[c].values[i];
    }
  }
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 16; ++x) image.channels[1].values[std::size_t(y * 40 + x)] += 0.5f;
  }
  image.channels[2].values[5 * 40 + 7] = std::numeric_limits<float>::quiet_NaN();
  return image;
}

// Two summation orders of 1400 doubles differ by less than 1400 * 2^-53 = 1.6e-13 of the sum of magnitudes;
// means of differences that nearly cancel lose three digits more.
void expect_close(double value, double expected) { EXPECT_NEAR(value, expected, 1e-10 * std::abs(expected)); }

// The expected numbers were computed by an independent program (NumPy) from the same images.
TEST(Metrics, AgreesWithAnIndependentProgram) {
  const Image reference = noise(1, 40, 35);
  const absl::StatusOr<Comparison> c = compare_images(reference, disturbed(reference));
  ASSERT_TRUE(c.ok()) << c.status();
  EXPECT_EQ(c->non_finite_pixels, 1u);
  expect_close(c->mse, 0.015605848054713517);
  expect_close(c->mse_trimmed, 0.015493396210256784);
  expect_close(c->relmse, 0.25007108597904587);
  expect_close(c->relmse_trimmed, 0.23833611363735135);
  EXPECT_EQ(c->blocks, 4u);
  EXPECT_EQ(c->blocks_rejected, 1u);
  EXPECT_EQ(c->block_tests, 12u);
  const ChannelBias expected[] = {{0.5086734143325261, 0.5095773041008839, 0.0011252575532125775,
                                   0.22121414674071854, 2.1002534133129496, 0.12653467284288814},
                                  {0.4931785779765674, 0.5839013910187142, 0.12455560356465867,
                                   25.255680016697063, 0.9967859295796366, 0.3923333632798075},
                                  {0.4851661637425423, 0.48511365638247556, -3.428609124966897e-05,
                                   -0.007066876013196829, -0.047654019423181586, 0.9649869488772514}};
  for (std::size_t i = 0; i < 3; ++i) {
    expect_close(c->channels[i].mean_reference, expected[i].mean_reference);
    expect_close(c->channels[i].mean_test, expected[i].mean_test);
    expect_close(c->channels[i].bias, expected[i].bias);
    expect_close(c->channels[i].bias_percent, expected[i].bias_percent);
    expect_close(c->channels[i].t, expected[i].t);
    expect_close(c->channels[i].p, expected[i].p);
  }
}

TEST(Metrics, AgreesOnRealImages) {
  const std::string scenes = "../shared/scenes/";
  if (!std::filesystem::exists(scenes)) GTEST_SKIP() << test::needs(scenes);
  const absl::StatusOr<Image> tungsten = read_exr(scenes + "pbrt/cornell-box/reference.exr");
  const absl::StatusOr<Image> mitsuba = read_exr(scenes + "mitsuba/cornell-box/reference-mitsuba.exr");
  ASSERT_TRUE(tungsten.ok() && mitsuba.ok());
  const absl::StatusOr<Comparison> c = compare_images(*tungsten, *mitsuba);
  ASSERT_TRUE(c.ok()) << c.status();
  expect_close(c->mse, 0.00012691612371327598);
  expect_close(c->relmse, 0.0013076696256008867);
  expect_close(c->relmse_trimmed, 0.0012624303850131409);
  expect_close(c->channels[0].p, 0.018085757989304684);
  EXPECT_EQ(c->blocks_rejected, 10u);
}

TEST(Metrics, EqualImagesHaveNoError) {
  const Image image = noise(1, 32, 32);
  const absl::StatusOr<Comparison> c = compare_images(image, image);
  ASSERT_TRUE(c.ok());
  EXPECT_EQ(c->mse, 0);
  EXPECT_EQ(c->relmse, 0);
  EXPECT_EQ(c->blocks_rejected, 0u);
  EXPECT_EQ(c->channels[1].p, 1);
}

/// relMSE of means over blocks, times their pixels: errors that agree count as often as there are pixels, and
/// those that cancel not at all.
TEST(Metrics, BlocksTellWhetherErrorsOfNeighboursAgree) {
  Image reference = noise(1, 40, 32), agreeing, cancelling;
  for (Channel& channel : reference.channels) std::ranges::fill(channel.values, 1.0f);
  agreeing = cancelling = reference;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < reference.pixel_count(); ++i) {
      agreeing.channels[c].values[i] += 0.125f;
      cancelling.channels[c].values[i] += (i % 40 + i / 40) % 2 == 0 ? 0.125f : -0.125f;
    }
  }
  constexpr double kOfPixels = 0.125 * 0.125 / 1.01;
  for (const int block : {1, 2, 8}) {
    CompareOptions options;
    options.block = block;
    const absl::StatusOr<Comparison> a = compare_images(reference, agreeing, options),
                                     b = compare_images(reference, cancelling, options);
    ASSERT_TRUE(a.ok() && b.ok());
    expect_close(a->relmse, kOfPixels);
    expect_close(b->relmse, kOfPixels);
    expect_close(a->relmse_block, kOfPixels * block * block);
    EXPECT_NEAR(b->relmse_block, block == 1 ? kOfPixels : 0, 1e-12);
  }
  CompareOptions options;
  options.block = 33;
  EXPECT_THAT(compare_images(reference, agreeing, options).status().message(),
              HasSubstr("smaller than one block of 33x33"));
}

TEST(Metrics, OneBlockIsEnough) {
  const Image image = noise(1, 16, 16);
  const absl::StatusOr<Comparison> same = compare_images(image, image);
  ASSERT_TRUE(same.ok());
  EXPECT_EQ(same->channels[0].p, 1);
  const absl::StatusOr<Comparison> other = compare_images(image, noise(2, 16, 16));
  ASSERT_TRUE(other.ok());
  EXPECT_EQ(other->channels[0].p, 0);
}

// Percentiles of Student's t from published tables, which have five digits.
TEST(Metrics, StudentTAgreesWithTables) {
  EXPECT_NEAR(student_t_p_value(12.7062, 1), 0.05, 1e-6);
  EXPECT_NEAR(student_t_p_value(-2.22814, 10), 0.05, 1e-6);
  EXPECT_NEAR(student_t_p_value(3.29053, 1e9), 0.001, 1e-7);
  EXPECT_EQ(student_t_p_value(0, 5), 1);
  EXPECT_EQ(student_t_p_value(std::numeric_limits<double>::infinity(), 5), 0);
}

TEST(Metrics, RefusesWhatCannotBeCompared) {
  const Image image = noise(1, 32, 32);
  const auto message = [](const Image& a, const Image& b) {
    const absl::Status status = compare_images(a, b).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  EXPECT_THAT(message(image, noise(1, 32, 31)), HasSubstr("32x32 and 32x31"));
  EXPECT_THAT(message(noise(1, 15, 20), noise(1, 15, 20)), HasSubstr("smaller than one block"));
  EXPECT_THAT(message(image, Image{}), HasSubstr("no channels"));
  Image bad = image;
  for (float& value : bad.channels[0].values) value = std::numeric_limits<float>::infinity();
  EXPECT_THAT(message(image, bad), HasSubstr("no pixel is finite"));
}

TEST(Metrics, TextAndJsonHaveTheNumbers) {
  const Image reference = noise(1, 40, 35);
  const Comparison c = *compare_images(reference, disturbed(reference));
  EXPECT_THAT(to_text(c), HasSubstr("relMSE 0.250071  (without worst 0.1 %: 0.238336)"));
  EXPECT_THAT(to_text(c), HasSubstr("block-channel tests rejected 1 of 12"));
  const nlohmann::json json = nlohmann::json::parse(to_json(c));
  EXPECT_EQ(json["size"], (std::vector<int>{40, 35}));
  EXPECT_EQ(json["relmse"], c.relmse);
  EXPECT_EQ(json["block"], 8);
  EXPECT_EQ(json["relmse_block"], c.relmse_block);
  EXPECT_EQ(json["channels"]["G"]["bias"], c.channels[1].bias);
  EXPECT_EQ(json["blocks_rejected"], 1);
}

}  // namespace
}  // namespace tessera::client
