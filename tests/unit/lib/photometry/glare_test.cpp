#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "photometry/glare/contrast.h"
#include "photometry/glare/glare_figures.h"

namespace tessera::photometry {
namespace {

using std::numbers::pi;
using testing::SizeIs;

/// Table 1 of CIE 117 for sources above the line of sight (T/R = 0), by height over distance. The fit follows
/// it to 3.5 %.
TEST(PositionIndex, IsThatOfGuthAboveTheLineOfSight) {
  const std::vector<std::pair<double, double>> table = {{0.1, 1.26}, {0.2, 1.53}, {0.3, 1.90}, {0.4, 2.35},
                                                        {0.5, 2.86}, {0.6, 3.50}, {0.7, 4.20}, {0.8, 5.00},
                                                        {0.9, 6.00}, {1.0, 7.00}};
  for (const auto& [height, published] : table) {
    const double length = std::hypot(height, 1);
    EXPECT_NEAR(position_index({0, height / length, 1 / length}) / published, 1, 0.035) << height;
  }
}

TEST(PositionIndex, GrowsAwayFromTheLineOfSight) {
  EXPECT_EQ(position_index({0, 0, 1}), 1);
  EXPECT_EQ(position_index({0, 0, -1}), 16);
  EXPECT_EQ(position_index({1, 0, 0}), 16);
  // Below it, 1 + 0.8 R up to R = 0.6, 1 + 1.2 R beyond, 4.6 at most [Iwata1997].
  const auto below = [](double r) {
    return position_index({0, -r / std::hypot(r, 1), 1 / std::hypot(r, 1)});
  };
  EXPECT_NEAR(below(0.5), 1.4, 1e-12);
  EXPECT_NEAR(below(1), 2.2, 1e-12);
  EXPECT_NEAR(below(5), 4.6, 1e-12);
  // The left is as the right.
  EXPECT_EQ(position_index({0.5, 0.3, 0.8}), position_index({-0.5, 0.3, 0.8}));
}

/// A hemisphere before the eye, equidistant, with a uniform luminance.
struct Fisheye {
  int size;
  std::vector<float> luminances;
  std::vector<ViewDirection> directions;
  std::vector<double> solid_angles;

  Fisheye(int side, float background) : size(side) {
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        const double right = 2 * (x + 0.5) / size - 1, up = 1 - 2 * (y + 0.5) / size;
        const double r = std::hypot(right, up), angle = r * pi / 2;
        directions.push_back({std::sin(angle) * right / r, std::sin(angle) * up / r, std::cos(angle)});
        solid_angles.push_back(r < 1 ? std::sin(angle) / angle * pi * pi / size / size : 0);
        luminances.push_back(background);
      }
    }
  }
  std::size_t at(int x, int y) const { return static_cast<std::size_t>(y * size + x); }
  void paint(int x0, int y0, int x1, int y1, float luminance) {
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) luminances[at(x, y)] = luminance;
  }
  LuminancePicture picture() const { return {size, size, luminances, directions, solid_angles}; }
};

TEST(Glare, UniformViewHasItsIlluminanceAndNoSource) {
  const Fisheye view(256, 500);
  const auto figures = glare_of(view.picture());
  ASSERT_TRUE(figures.ok()) << figures.status();
  // Pixels at the border of the circle are in or out: an error of about 256^-1.5.
  EXPECT_NEAR(figures->vertical_illuminance / (500 * pi), 1, 1e-3);
  EXPECT_NEAR(figures->mean_luminance, 500, 1e-9);
  EXPECT_NEAR(figures->background_luminance, figures->vertical_illuminance / pi, 1e-9);
  EXPECT_TRUE(figures->found.sources.empty());
  EXPECT_EQ(figures->unified_glare_rating, -std::numeric_limits<double>::infinity());
  EXPECT_NEAR(figures->daylight_glare_probability, 0.16 + 5.87e-5 * figures->vertical_illuminance, 1e-12);
}

/// 8 lg (0.25 / Lb L^2 w / p^2), with p = 1 on the line of sight.
TEST(Glare, UnifiedRatingOfOneSourceIsTheClosedForm) {
  Fisheye view(128, 100);
  view.paint(60, 60, 68, 68, 20'000);
  const auto figures = glare_of(view.picture());
  ASSERT_TRUE(figures.ok());
  ASSERT_THAT(figures->found.sources, SizeIs(1));
  const GlareSource& source = figures->found.sources[0];
  EXPECT_EQ(source.pixels, 64u);
  EXPECT_NEAR(source.luminance, 20'000, 1e-6);
  // A square of 8 pixels, 8/128 of 180 degrees = 0.19635 rad across; smaller by the mean of sin x / x over
  // it, 0.9989.
  EXPECT_NEAR(source.solid_angle / (0.19635 * 0.19635 * 0.9989), 1, 1e-3);
  EXPECT_NEAR(source.middle.forward, 1, 1e-12);
  EXPECT_NEAR(source.position_index, 1, 1e-6);
  // The background: a hemisphere of 100 cd/m^2 less what the source hides, about w / pi of it.
  EXPECT_NEAR(figures->background_luminance, 100 * (1 - source.solid_angle / pi), 0.2);
  EXPECT_NEAR(figures->unified_glare_rating,
              8 * std::log10(0.25 / figures->background_luminance * 4e8 * source.solid_angle), 1e-9);
  EXPECT_NEAR(figures->vertical_illuminance, 100 * pi + 19'900 * source.solid_angle, 5);
}

/// Two alike sources are 8 lg 2 = 2.41 more than one.
TEST(Glare, RatingsAddSources) {
  const GlareSource one{.luminance = 5000, .solid_angle = 0.02, .position_index = 2};
  const std::vector<GlareSource> two = {one, one};
  EXPECT_NEAR(unified_glare_rating(two, 50) - unified_glare_rating({&one, 1}, 50), 8 * std::log10(2), 1e-12);
  EXPECT_NEAR(daylight_glare_index(two, 50) - daylight_glare_index({&one, 1}, 50), 10 * std::log10(2), 1e-12);
}

/// By hand: L^2 w / P^2 = 10^6; 1000^1.87 = 10^5.61 = 407,380; lg (1 + 2.45471) = 0.53841; 0.0587 +
/// 0.0494262 + 0.16.
TEST(Glare, ProbabilityIsTheFormulaByHand) {
  const GlareSource source{.luminance = 10'000, .solid_angle = 0.01, .position_index = 1};
  EXPECT_NEAR(daylight_glare_probability({&source, 1}, 1000), 0.268126, 1e-5);
  EXPECT_EQ(daylight_glare_probability({&source, 1}, 1e6), 1);
  EXPECT_NEAR(daylight_glare_probability({}, 0), 0.16, 1e-12);
  // At 100 lx, times exp(-1.6) / (1 + exp(-1.6)) = 0.167982; at 1000 lx, times 1 to 9 digits.
  EXPECT_NEAR(daylight_glare_probability({}, 100, true), 0.167982 * (0.16 + 0.00587), 1e-6);
  EXPECT_NEAR(daylight_glare_probability({}, 1000, true), 0.16 + 0.0587, 1e-8);
}

/// L = 10,000, w = 0.01, P = 2, Lb = 100: 10,000^1.6 = 2,511,886; (0.01 / 4)^0.8 = 0.0082861; over 100 + 0.07
/// x 0.1 x 10,000 = 170: 0.478 x 2,511,886 x 0.0082861 / 170 = 58.524, and ten times its logarithm.
TEST(Glare, DaylightIndexIsTheFormulaByHand) {
  const GlareSource source{.luminance = 10'000, .solid_angle = 0.01, .position_index = 2};
  EXPECT_NEAR(daylight_glare_index({&source, 1}, 100), 10 * std::log10(58.524), 2e-3);
}

TEST(GlareSources, NearOnesAreOne) {
  // Two windows of 4 x 4 pixels, 14 pixels from middle to middle: 14/128 of 180 degrees = 0.344 rad.
  Fisheye view(128, 100);
  view.paint(55, 40, 59, 44, 9000);
  view.paint(69, 40, 73, 44, 9000);
  EXPECT_THAT(find_glare_sources(view.picture(), {.search_radius = 0.2}).sources, SizeIs(2));
  const FoundSources merged = find_glare_sources(view.picture(), {.search_radius = 0.4});
  ASSERT_THAT(merged.sources, SizeIs(1));
  EXPECT_EQ(merged.sources[0].pixels, 32u);
  EXPECT_NEAR(merged.sources[0].middle.right, 0, 1e-12);
  EXPECT_EQ(merged.source_of_pixel[view.at(56, 41)], 1);
  EXPECT_EQ(merged.source_of_pixel[view.at(70, 41)], 1);
  EXPECT_EQ(merged.source_of_pixel[view.at(64, 41)], 0);
}

TEST(GlareSources, PixelsThatTouchAreOne) {
  Fisheye view(64, 100);
  view.luminances[view.at(30, 30)] = view.luminances[view.at(31, 31)] = 5000;  // at a corner
  view.luminances[view.at(29, 32)] = view.luminances[view.at(30, 31)] = 5000;
  EXPECT_THAT(find_glare_sources(view.picture(), {.search_radius = 0}).sources, SizeIs(1));
  view.luminances[view.at(40, 31)] = 5000;
  const FoundSources two = find_glare_sources(view.picture(), {.search_radius = 0});
  ASSERT_THAT(two.sources, SizeIs(2));
  EXPECT_EQ(two.sources[0].pixels, 4u);  // the stronger one first
}

TEST(GlareSources, ThresholdIsOfTheTaskOrTheView) {
  Fisheye view(64, 100);
  view.paint(10, 20, 14, 24, 800);
  // Seven times the mean of the view, which the patch hardly changes; below 2000.
  EXPECT_THAT(find_glare_sources(view.picture(), {}).sources, SizeIs(0));
  EXPECT_THAT(find_glare_sources(view.picture(), {.threshold = 0, .factor = 5}).sources, SizeIs(1));
  // A bright desk in the middle: 300 cd/m^2, of which 5 times are more than 800.
  view.paint(28, 28, 36, 36, 300);
  const TaskZone desk{.middle = {0, 0, 1}, .radius_degrees = 8};
  EXPECT_NEAR(mean_luminance(view.picture(), desk), 300, 1e-9);
  EXPECT_THAT(find_glare_sources(view.picture(), {.threshold = 0, .factor = 5, .task = desk}).sources,
              SizeIs(0));
  EXPECT_THAT(find_glare_sources(view.picture(), {.threshold = 0, .factor = 2, .task = desk}).sources,
              SizeIs(1));
}

TEST(Glare, RefusesPicturesThatAreNone) {
  Fisheye view(8, 100);
  view.luminances.pop_back();
  EXPECT_FALSE(glare_of(view.picture()).ok());
  view.luminances.push_back(-1);
  EXPECT_FALSE(glare_of(view.picture()).ok());
  view.luminances.back() = 1;
  EXPECT_TRUE(glare_of(view.picture()).ok());
  EXPECT_FALSE(glare_of(view.picture(), {.search = {.search_radius = -1}}).ok());
}

TEST(Contrast, IsThatOfWeberAndMichelson) {
  EXPECT_DOUBLE_EQ(weber_contrast(30, 20), 0.5);
  EXPECT_DOUBLE_EQ(weber_contrast(5, 20), -0.75);
  EXPECT_DOUBLE_EQ(michelson_contrast(30, 10), 0.5);
  EXPECT_DOUBLE_EQ(michelson_contrast(10, 30), 0.5);
  EXPECT_DOUBLE_EQ(luminance_ratio(10, 30), 3);
  EXPECT_EQ(luminance_ratio(0, 0), 1);
  EXPECT_EQ(luminance_ratio(0, 2), std::numeric_limits<double>::infinity());
  EXPECT_EQ(michelson_contrast(0, 0), 0);
  const std::vector<double> grid = {200, 300, 400};
  EXPECT_DOUBLE_EQ(uniformity(grid), 2.0 / 3);
  EXPECT_DOUBLE_EQ(diversity(grid), 0.5);
  EXPECT_EQ(uniformity({}), 0);
}

}  // namespace
}  // namespace tessera::photometry
