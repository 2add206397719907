#include "denoise/denoise.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "absl/strings/str_cat.h"
#include "wire/halves.h"

namespace tessera::client {
namespace {

using ::testing::HasSubstr;

constexpr int kSamples = 16;

/// The pixel without noise.
using Truth = std::function<float(int x, int y)>;

/// A picture of `kSamples` samples a pixel with errors of variance `noise`^2 a sample, normally distributed,
/// and the channels that denoising asks for. Albedo, normal and depth are those of one wall.
Image noisy(int width, int height, const Truth& truth, float noise, std::uint32_t seed) {
  Image image;
  image.data = image.display = {0, 0, width, height};
  image.metadata["tessera.spp"] = kSamples;
  for (const char* name : {"R",
                           "G",
                           "B",
                           "A",
                           "variance.R",
                           "variance.G",
                           "variance.B",
                           "albedo.R",
                           "albedo.G",
                           "albedo.B",
                           "normal.X",
                           "normal.Y",
                           "normal.Z",
                           "depth.Z",
                           "half.R",
                           "half.G",
                           "half.B",
                           "half.albedo.R",
                           "half.albedo.G",
                           "half.albedo.B",
                           "half.normal.X",
                           "half.normal.Y",
                           "half.normal.Z",
                           "half.depth.Z"})
    image.add(name);
  const auto plane = [&](const std::string& name) -> std::vector<float>& {
    return std::ranges::find(image.channels, name, &Channel::name)->values;
  };
  std::mt19937 random(seed);
  std::normal_distribution<float> error(0, noise);
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    const float mean = truth(static_cast<int>(i) % width, static_cast<int>(i) / width);
    for (const std::string c : {"R", "G", "B"}) {
      double sum = 0, squares = 0, half = 0;
      for (std::uint32_t s = 0; s < kSamples; ++s) {
        const float sample = mean + error(random);
        sum += sample, squares += double{sample} * sample;
        half += wire::in_first_half(s) ? sample : 0;
      }
      plane(c)[i] = static_cast<float>(sum / kSamples);
      plane("half." + c)[i] = static_cast<float>(2 * half / kSamples);
      plane("variance." + c)[i] = static_cast<float>((squares - sum * sum / kSamples) / (kSamples - 1));
      plane("albedo." + c)[i] = plane("half.albedo." + c)[i] = 0.5f;
    }
    plane("A")[i] = 1;
    plane("normal.Z")[i] = plane("half.normal.Z")[i] = 1;
    plane("depth.Z")[i] = plane("half.depth.Z")[i] = 3;
  }
  return image;
}

double mean_square_error(const Image& image, const Truth& truth, const char* channel = "R") {
  const std::vector<float>& values = image.find(channel)->values;
  double sum = 0;
  const int width = image.data.width();
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double error = values[i] - truth(static_cast<int>(i) % width, static_cast<int>(i) / width);
    sum += error * error;
  }
  return sum / static_cast<double>(values.size());
}

class Denoise : public ::testing::TestWithParam<DenoiseMethod> {
 protected:
  Image denoised(Image image, int threads = 1) const {
    const auto done = denoise_image({.method = GetParam(), .threads = threads, .oidn_library = ""}, image);
    EXPECT_TRUE(done.ok()) << done.status();
    return image;
  }
};

// 60 x 50 pixels of one value: the mean of n alike pixels has 1 / n of the variance. A window has 361 pixels
// or more, of which those that count fall to a quarter in a corner; a tenth of the error is far from both.
TEST_P(Denoise, AveragesWhatIsEqual) {
  const Truth flat = [](int, int) { return 0.5f; };
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    const Image raw = noisy(60, 50, flat, 0.2f, seed);
    EXPECT_LT(mean_square_error(denoised(raw), flat), 0.1 * mean_square_error(raw, flat));
  }
}

// Light and shadow on one wall, 20 standard errors apart: the step stays where it is, as steep as it is.
TEST_P(Denoise, KeepsWhatDiffersSignificantly) {
  const Truth step = [](int x, int) { return x < 31 ? 0.2f : 1.2f; };
  const Image raw = noisy(64, 48, step, 0.2f, 4), clean = denoised(raw);
  const std::vector<float>& red = clean.find("R")->values;
  for (std::size_t y = 0; y < 48; ++y) {
    EXPECT_NEAR(red[y * 64 + 30], 0.2f, 0.15f) << y;
    EXPECT_NEAR(red[y * 64 + 31], 1.2f, 0.15f) << y;
  }
  EXPECT_LT(mean_square_error(clean, step), 0.25 * mean_square_error(raw, step));
}

TEST_P(Denoise, HasTheSameBitsForAnyNumberOfThreads) {
  const Truth slope = [](int x, int y) { return 0.01f * static_cast<float>(x + y); };
  const Image raw = noisy(150, 70, slope, 0.3f, 5);
  const Image one = denoised(raw), many = denoised(raw, 5);
  for (const char* name : {"R", "G", "B"}) EXPECT_EQ(one.find(name)->values, many.find(name)->values) << name;
}

TEST_P(Denoise, KeepsTheRawPictureAndSaysWhatItDid) {
  const Truth flat = [](int, int) { return 0.5f; };
  Image raw = noisy(20, 20, flat, 0.2f, 6);
  raw.metadata["tessera.integrator"] = "path";
  raw.metadata["tessera.integrator_kind"] = "unbiased";
  Image clean = denoised(raw);
  EXPECT_EQ(clean.find("raw.R")->values, raw.find("R")->values);
  EXPECT_EQ(clean.find("A")->values, raw.find("A")->values);
  EXPECT_TRUE(is_denoised(clean));
  EXPECT_FALSE(is_denoised(raw));
  EXPECT_THAT(std::get<std::string>(clean.metadata["tessera.denoised"]), HasSubstr("biased"));
  EXPECT_EQ(std::get<std::string>(clean.metadata["tessera.integrator_kind"]), "biased");
  // Again, from the raw one.
  const Image again = denoised(clean);
  EXPECT_EQ(again.find("R")->values, clean.find("R")->values);
  EXPECT_EQ(again.channels.size(), clean.channels.size());
  EXPECT_EQ(std::get<std::string>(again.metadata.at("tessera.integrator")), "path + denoised");
}

TEST_P(Denoise, FillsWhatIsNotFiniteAndCutsLoneFireflies) {
  const Truth flat = [](int, int) { return 0.5f; };
  Image raw = noisy(40, 40, flat, 0.05f, 7);
  const auto set = [&](const char* name, std::size_t i, float value) {
    std::ranges::find(raw.channels, name, &Channel::name)->values[i] = value;
  };
  set("R", 410, std::numeric_limits<float>::quiet_NaN());
  set("variance.G", 411, std::numeric_limits<float>::infinity());
  for (const char* name : {"R", "G", "B"}) set(name, 830, 1000);  // second half only: half.* are as before
  const Image clean = denoised(raw);
  for (const char* name : {"R", "G", "B"}) {
    for (const float value : clean.find(name)->values) ASSERT_NEAR(value, 0.5f, 0.2f) << name;
  }
  EXPECT_EQ(std::get<std::int32_t>(clean.metadata.at("tessera.fireflies_cut")), 1);
}

TEST_P(Denoise, TakesPicturesOfAnySize) {
  const Truth flat = [](int, int) { return 0.5f; };
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 1}, {1, 70}, {17, 5}, {65, 66}}) {
    const Image clean = denoised(noisy(width, height, flat, 0.1f, 8));
    for (const float value : clean.find("G")->values)
      EXPECT_NEAR(value, 0.5f, 0.2f) << width << "x" << height;
  }
}

TEST_P(Denoise, NamesWhatIsMissing) {
  Image image = noisy(
      8, 8, [](int, int) { return 1.0f; }, 0.1f, 9);
  std::erase_if(image.channels, [](const Channel& c) { return c.name == "half.G" || c.name == "depth.Z"; });
  const auto status = denoise_image({.method = GetParam(), .threads = 1, .oidn_library = ""}, image).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status));
  EXPECT_THAT(std::string{status.message()}, HasSubstr("half.G, depth.Z"));
  EXPECT_THAT(std::string{status.message()}, HasSubstr("--aov variance,albedo,normal,depth,halves"));
  image.metadata["tessera.spp"] = 1;
  EXPECT_THAT(
      std::string{
          denoise_image({.method = GetParam(), .threads = 1, .oidn_library = ""}, image).status().message()},
      HasSubstr("one sample"));
}

INSTANTIATE_TEST_SUITE_P(, Denoise,
                         ::testing::Values(DenoiseMethod::kStatistical, DenoiseMethod::kRegression),
                         [](const auto& method) { return word_of(method.param); });

TEST(DenoiseByOidn, SaysThatItIsNotHere) {
  Image image = noisy(
      8, 8, [](int, int) { return 1.0f; }, 0.1f, 10);
  const auto status =
      denoise_image({.method = DenoiseMethod::kOidn, .threads = 1, .oidn_library = "/nowhere/liboidn.so"},
                    image)
          .status();
  EXPECT_TRUE(absl::IsNotFound(status));
  EXPECT_THAT(std::string{status.message()}, HasSubstr("/nowhere/liboidn.so"));
  EXPECT_THAT(std::string{status.message()}, HasSubstr("TESSERA_OIDN"));
  EXPECT_FALSE(is_denoised(image));
}

absl::Status by_library(const std::string& library, Image& image) {
  return denoise_image({.method = DenoiseMethod::kOidn, .threads = 1, .oidn_library = library}, image)
      .status();
}

TEST(DenoiseByOidn, GivesTheLibraryColourAlbedoAndNormal) {
  const Truth slope = [](int x, int y) { return 0.1f * static_cast<float>(x + 2 * y); };
  const Image raw = noisy(9, 5, slope, 0.1f, 11);
  Image image = raw;
  ASSERT_TRUE(by_library(TESSERA_FALSE_OIDN, image).ok());
  for (const char* name : {"R", "B"}) {  // albedo 0.5; the normal is (0, 0, 1)
    const float other = 0.25f * (0.5f + (name[0] == 'B' ? 1.0f : 0.0f));
    for (std::size_t i = 0; i < raw.pixel_count(); ++i)
      EXPECT_NEAR(image.find(name)->values[i], 0.5f * raw.find(name)->values[i] + other, 1e-5f) << name << i;
  }
  EXPECT_EQ(std::get<std::string>(image.metadata["tessera.denoised"]), "oidn, biased");
}

TEST(DenoiseByOidn, PassesOnWhatTheLibrarySays) {
  const Truth flat = [](int, int) { return 0.5f; };
  Image image = noisy(7, 4, flat, 0.1f, 12);  // a width that the false one refuses
  EXPECT_EQ(by_library(TESSERA_FALSE_OIDN, image), absl::InternalError("Open Image Denoise: what it says"));
  EXPECT_EQ(by_library("libm.so.6", image),
            absl::InternalError("the library is not Open Image Denoise 1 or 2"));
  EXPECT_FALSE(is_denoised(image));
}

TEST(Halves, AreEqualForPowersOfTwoAndKnownForAll) {
  std::uint32_t first = 0;
  for (std::uint32_t n = 1; n <= 5000; ++n) {
    first += wire::in_first_half(n - 1) ? 1 : 0;
    ASSERT_EQ(wire::first_half_of(n), first) << n;
    if (n > 1 && std::has_single_bit(n)) {
      EXPECT_EQ(first, n / 2);
    }
  }
}

}  // namespace
}  // namespace tessera::client
