// Pictures of what moves: against closed forms, against the mean of still pictures, and integrators against
// each other.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "render/scene/load_scene.h"
#include "support/picture/scene_file.h"

namespace tessera::test {
namespace {

constexpr int kSide = 32;
constexpr const char* kFilm = "film { width: 32 height: 32 filter { kind: BOX } } ";

struct Settings {
  std::uint32_t spp = 1024, max_depth = 0;
  std::uint64_t seed = 1;
  std::string integrator = "path";
};

/// Mean of the red channel over a pixel's samples; empty when it fails.
std::vector<double> render(const std::string& scene, const Settings& settings) {
  test::SceneJob job;
  job.settings.set_spp(settings.spp);
  job.settings.set_max_depth(settings.max_depth);
  job.settings.set_seed(settings.seed);
  job.settings.set_sampler(v1::SAMPLER_INDEPENDENT);
  job.settings.set_integrator(settings.integrator);
  const auto file = load_scene_text(absl::StrCat(scene, kFilm), job, render::supported_isas().front());
  EXPECT_TRUE(file.ok()) << file.status();
  if (!file.ok()) return {};
  render::RenderStats stats;
  const auto tile = file->scene->render_tile({0, 0, kSide, kSide, 0, settings.spp}, {}, stats);
  EXPECT_TRUE(tile.ok()) << tile.status();
  EXPECT_EQ(stats.dropped_samples, 0u);
  if (!tile.ok()) return {};
  std::vector<double> mean(tile->values.begin(), tile->values.begin() + kSide * kSide);
  for (double& x : mean) x /= settings.spp;
  return mean;
}

/// A black shape before a sky of radiance 1, seen by parallel rays through the square [-1, 1]^2. `covered(x,
/// y)` is the part of the time that the shape hides a place; pixels where it jumps are to be NaN.
void expect_coverage(const std::string& shape, const std::function<double(double, double)>& covered) {
  const Settings settings{4096};
  const std::vector<double> mean =
      render(absl::StrCat("lights { infinite { radiance { constant: 1 } } } camera { orthographic { } "
                          "world_from_camera { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-4, 0,0,0,1] } } shapes { ",
                          shape, " } "),
             settings);
  ASSERT_FALSE(mean.empty());
  int compared = 0;
  for (int py = 0; py < kSide; ++py) {
    for (int px = 0; px < kSide; ++px) {
      constexpr int kSub = 16;
      double p = 0;
      for (int i = 0; i < kSub * kSub; ++i) {
        const double x = -1 + 2 * (px + (i % kSub + 0.5) / kSub) / kSide,
                     y = 1 - 2 * (py + (i / kSub + 0.5) / kSub) / kSide;
        p += covered(x, y) / (kSub * kSub);
      }
      if (std::isnan(p)) continue;
      ++compared;
      // Samples are hidden or not: a binomial distribution. 5.5 standard deviations: one false alarm in
      // 25,000 pictures; 1e-3 for the quadrature over the pixel, whose integrand has a bend here and there.
      const double deviation = std::abs(mean[static_cast<std::size_t>(py * kSide + px)] - (1 - p));
      const double tolerance = 5.5 * std::sqrt(std::max(p * (1 - p), 0.0) / settings.spp) + 1e-3;
      EXPECT_LT(deviation, tolerance) << "pixel " << px << ", " << py << ": expected " << 1 - p;
    }
  }
  EXPECT_GT(compared, kSide * kSide / 2);
}

TEST(MotionBlur, ASlidingDiskHidesEveryPlaceForItsTime) {
  const double radius = 0.4, from = -0.7, to = 0.3;
  expect_coverage(
      absl::StrFormat(
          "disk { radius: %g } world_from_object { elements: [1,0,0,%g, 0,1,0,0, 0,0,1,0, 0,0,0,1] } "
          "world_from_object_end { elements: [1,0,0,%g, 0,1,0,0, 0,0,1,0, 0,0,0,1] }",
          radius, from, to),
      [&](double x, double y) {
        if (std::abs(y) >= radius) return 0.0;
        const double half = std::sqrt(radius * radius - y * y);
        return std::max(0.0, std::min(x + half, to) - std::max(x - half, from)) / (to - from);
      });
}

TEST(MotionBlur, ASphereThatGrowsUncoversEveryPlaceInTime) {
  // Its radius grows from 0.2 to 0.9.
  expect_coverage(
      "sphere { radius: 1 } world_from_object { elements: [0.2,0,0,0, 0,0.2,0,0, 0,0,0.2,0, 0,0,0,1] } "
      "world_from_object_end { elements: [0.9,0,0,0, 0,0.9,0,0, 0,0,0.9,0, 0,0,0,1] }",
      [](double x, double y) { return std::clamp((0.9 - std::hypot(x, y)) / 0.7, 0.0, 1.0); });
}

TEST(MotionBlur, ATurningSectorHidesEveryAngleForItsTime) {
  // A quarter of a disk that turns by 60 degrees about its centre.
  const double turn = std::numbers::pi / 3, c = std::cos(turn), s = std::sin(turn);
  expect_coverage(
      absl::StrFormat("disk { radius: 0.9 phi_max_degrees: 90 } world_from_object_end { elements: "
                      "[%.15g,%.15g,0,0, %.15g,%.15g,0,0, 0,0,1,0, 0,0,0,1] }",
                      c, -s, s, c),
      [&](double x, double y) {
        const double r = std::hypot(x, y);
        // Not at the rim, and not near the centre, where a pixel sees many angles.
        if (std::abs(r - 0.9) < 0.1 || r < 0.2) return std::nan("");
        if (r > 0.9) return 0.0;
        double angle = std::atan2(y, x);
        if (angle < -std::numbers::pi / 2) angle += 2 * std::numbers::pi;
        return std::max(0.0, std::min(angle, turn) - std::max(angle - std::numbers::pi / 2, 0.0)) / turn;
      });
}

/// A wall with a lamp, and between them a veil that slides and turns from time `begin` to `end`.
std::string shadow_scene(double begin, double end, double opacity) {
  const auto placed = [](double t) {
    const double angle = 0.8 * t, c = std::cos(angle), s = std::sin(angle);
    return absl::StrFormat("elements: [%.15g,0,%.15g,%.15g, 0,1,0,0.2, %.15g,0,%.15g,4, 0,0,0,1]", c, s,
                           -1 + 2 * t, -s, c);
  };
  return absl::StrCat(R"(
    camera { perspective { fov_degrees: 50 } }
    lights { point { position { x: -1 y: 1 z: 1 } intensity { constant: 30 } } }
    materials { name: 'wall' diffuse { reflectance { constant { constant: 0.7 } } } }
    materials { name: 'veil' diffuse { reflectance { constant { constant: 0.4 } } } )",
                      opacity < 1 ? absl::StrFormat("opacity { constant: %g } ", opacity) : "", R"(}
    shapes { disk { radius: 20 } material: 'wall'
      world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,-1,6, 0,0,0,1] } }
    shapes { disk { radius: 0.8 } material: 'veil' world_from_object { )",
                      placed(begin), " } ",
                      end > begin ? absl::StrCat("world_from_object_end { ", placed(end), " } ") : "", "}\n");
}

struct Blocks {
  std::vector<double> mean, squared_error;
};

/// Means over blocks of 4 x 4 pixels, with the squared standard errors that `repeats` pictures with different
/// seeds show.
Blocks blocks_of(int repeats, const std::function<std::vector<double>(int)>& picture) {
  constexpr int kBlock = 4, kBlocks = kSide / kBlock;
  Blocks result{std::vector<double>(kBlocks * kBlocks), std::vector<double>(kBlocks * kBlocks)};
  for (int r = 0; r < repeats; ++r) {
    const std::vector<double> image = picture(r);
    if (image.empty()) return {};
    std::vector<double> block(kBlocks * kBlocks);
    for (int i = 0; i < kSide * kSide; ++i) {
      block[static_cast<std::size_t>(i / kSide / kBlock * kBlocks + i % kSide / kBlock)] +=
          image[static_cast<std::size_t>(i)] / (kBlock * kBlock);
    }
    for (std::size_t b = 0; b < block.size(); ++b) {
      result.mean[b] += block[b] / repeats;
      result.squared_error[b] += block[b] * block[b] / repeats;
    }
  }
  for (std::size_t b = 0; b < result.mean.size(); ++b) {
    const double variance = std::max(0.0, result.squared_error[b] - result.mean[b] * result.mean[b]);
    result.squared_error[b] = variance / (repeats - 1);
  }
  return result;
}

/// Errors that are estimated from 16 pictures each have a t distribution with about 30 degrees of freedom:
/// beyond 6.5 once in 3 million blocks. `bias` is relative.
void expect_equal(const Blocks& a, const Blocks& b, double bias) {
  ASSERT_FALSE(a.mean.empty());
  ASSERT_EQ(a.mean.size(), b.mean.size());
  double sum_a = 0, sum_b = 0, error = 0;
  for (std::size_t i = 0; i < a.mean.size(); ++i) {
    const double squared = a.squared_error[i] + b.squared_error[i];
    EXPECT_NEAR(a.mean[i], b.mean[i], 6.5 * std::sqrt(squared) + bias * b.mean[i]) << "block " << i;
    sum_a += a.mean[i], sum_b += b.mean[i], error += squared;
  }
  EXPECT_NEAR(sum_a, sum_b, 5 * std::sqrt(error) + bias * sum_b);
}

constexpr int kRepeats = 16;

Blocks moving_blocks(const std::string& integrator, double opacity, std::uint64_t seed) {
  return blocks_of(kRepeats, [&](int r) {
    return render(shadow_scene(0, 1, opacity), {64, 3, seed + static_cast<std::uint64_t>(r), integrator});
  });
}

/// One still picture in each of 64 equal parts of the time, at another place within it in every repetition.
Blocks still_blocks(const std::string& integrator, double opacity) {
  std::uint64_t seed = 1000;
  return blocks_of(kRepeats, [&](int r) {
    std::vector<double> sum(kSide * kSide);
    constexpr int kParts = 64;
    for (int part = 0; part < kParts; ++part) {
      const double within = std::fmod(0.5 + 0.6180339887498949 * (r * kParts + part), 1.0);
      const double time = (part + within) / kParts;
      const std::vector<double> image = render(shadow_scene(time, time, opacity), {4, 3, seed++, integrator});
      if (image.empty()) return image;
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += image[i] / kParts;
    }
    return sum;
  });
}

// 1e-3: the places in time are spread evenly instead of at random.
TEST(MotionBlur, IsTheMeanOfStillPictures) {
  expect_equal(moving_blocks("path", 1, 1), still_blocks("path", 1), 1e-3);
}

TEST(MotionBlur, IsTheMeanOfStillPicturesThroughAVeil) {
  expect_equal(moving_blocks("volpath", 0.6, 1), still_blocks("volpath", 0.6), 1e-3);
}

TEST(MotionBlur, IsTheSameFromTheLightsAndFromTheEye) {
  expect_equal(moving_blocks("light", 1, 101), moving_blocks("path", 1, 1), 0);
}

TEST(MotionBlur, AFastFloorInAFurnaceShowsItsAlbedo) {
  // It slides by 60 and turns by 60 degrees under a sky of radiance 1, and is always under the camera.
  const double turn = std::numbers::pi / 3, c = std::cos(turn), s = std::sin(turn);
  const std::string scene = absl::StrFormat(
      "lights { infinite { radiance { constant: 1 } } } materials { name: 'm' diffuse { reflectance { "
      "constant { constant: 0.5 } } } } "
      "camera { perspective { fov_degrees: 60 } world_from_camera { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-4, "
      "0,0,0,1] } } "
      "shapes { disk { radius: 200 } material: 'm' world_from_object { elements: [1,0,0,-30, 0,1,0,0, "
      "0,0,1,0, 0,0,0,1] } "
      "world_from_object_end { elements: [%.15g,%.15g,0,30, %.15g,%.15g,0,0, 0,0,1,0, 0,0,0,1] } } ",
      c, -s, s, c);
  const Blocks blocks = blocks_of(kRepeats, [&](int r) {
    return render(scene, {64, 5, 1 + static_cast<std::uint64_t>(r), "path"});
  });
  expect_equal(blocks, {std::vector<double>(64, 0.5), std::vector<double>(64, 0.0)}, 1e-6);
}

}  // namespace
}  // namespace tessera::test
