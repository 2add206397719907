// Pictures of what moves through several keys, by shutters' curves and row by row: against closed forms.
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
#include "support/picture/p_values.h"
#include "support/picture/scene_file.h"

namespace tessera::test::shutter_coverage {
namespace {

constexpr int kSide = 32;
constexpr std::uint32_t kSamples = 1024, kSeeds = 4;

struct Rows {
  std::uint32_t first = 0, end = kSide;
};

/// How often samples of each pixel of these rows see the sky, whose radiance is 1.
std::vector<double> hits_of_sky(const std::string& scene, std::uint64_t seed,
                                std::uint32_t samples = kSamples, Rows rows = {}) {
  test::SceneJob job;
  job.settings.set_spp(samples);
  job.settings.set_max_depth(0);
  job.settings.set_seed(seed);
  job.settings.set_sampler(v1::SAMPLER_INDEPENDENT);
  job.settings.set_integrator("path");
  const auto file =
      load_scene_text(absl::StrCat(scene, " film { width: 32 height: 32 filter { kind: BOX } }"), job,
                      render::supported_isas().front());
  EXPECT_TRUE(file.ok()) << file.status();
  if (!file.ok()) return {};
  EXPECT_TRUE(file->scene->warnings().empty()) << file->scene->warnings().front();
  render::RenderStats stats;
  const auto tile = file->scene->render_tile({0, rows.first, kSide, rows.end, 0, samples}, {}, stats);
  EXPECT_TRUE(tile.ok()) << tile.status();
  if (!tile.ok()) return {};
  return {tile->values.begin(), tile->values.begin() + kSide * (rows.end - rows.first)};
}

/// Fails where p-values of one hypothesis, those of its pixels, are too small.
void expect_likely(const std::vector<double>& p_values) {
  EXPECT_GT(p_values.size(), std::size_t{kSide * kSide / 2});
  const std::vector<double> adjusted = holm_adjusted(p_values);
  EXPECT_GT(*std::ranges::min_element(adjusted), 1e-4);
  EXPECT_GT(fisher_p_value(p_values), 1e-4);
}

/// A black shape before the sky, seen by parallel rays through the square [-1, 1]^2 with a camera's further
/// fields. `covered(x, y, row)` is the part of the exposure for which the shape hides a place of a row;
/// pixels where it jumps are to be NaN. Of a pixel, hits are a binomial number; p-values of seeds and pixels
/// are combined as those of tests of one hypothesis.
void expect_coverage(const std::string& camera, const std::string& shape,
                     const std::function<double(double, double, int)>& covered) {
  const std::string scene = absl::StrCat(
      "lights { infinite { radiance { constant: 1 } } } camera { orthographic { } world_from_camera { "
      "elements: [1,0,0,0, 0,1,0,0, 0,0,1,-4, 0,0,0,1] } ",
      camera, " } shapes { ", shape, " } ");
  std::vector<double> seen(kSide * kSide);
  for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
    const std::vector<double> hits = hits_of_sky(scene, seed);
    ASSERT_FALSE(hits.empty());
    for (std::size_t i = 0; i < hits.size(); ++i) seen[i] += hits[i];
  }
  constexpr double kTrials = double{kSamples} * kSeeds;
  std::vector<double> p_values;
  for (int py = 0; py < kSide; ++py) {
    for (int px = 0; px < kSide; ++px) {
      constexpr int kSub = 32;
      double p = 0;
      for (int i = 0; i < kSub * kSub; ++i) {
        const double x = -1 + 2 * (px + (i % kSub + 0.5) / kSub) / kSide,
                     y = 1 - 2 * (py + (i / kSub + 0.5) / kSub) / kSide;
        p += (1 - covered(x, y, py)) / (kSub * kSub);
      }
      if (std::isnan(p)) continue;
      const double n = seen[static_cast<std::size_t>(py * kSide + px)];
      // 5e-4 for the quadrature over the pixel, whose integrand has bends.
      p_values.push_back(
          interval_p_value(n / kTrials - p, 5e-4, std::sqrt(std::max(p * (1 - p), 1e-4) / kTrials)));
    }
  }
  expect_likely(p_values);
}

constexpr double kRadius = 0.4;

std::string placed(double x) {
  return absl::StrFormat("{ elements: [1,0,0,%.15g, 0,1,0,0, 0,0,1,0, 0,0,0,1] }", x);
}

struct Key {
  double time, x;
};

/// A disk that slides along x from key to key; the first is at time 0.
std::string sliding(const std::vector<Key>& keys) {
  std::string shape = absl::StrFormat("disk { radius: %g } world_from_object %s", kRadius, placed(keys[0].x));
  for (std::size_t i = 1; i < keys.size(); ++i)
    absl::StrAppend(&shape, " motion { time: ", keys[i].time, " place ", placed(keys[i].x), " }");
  return shape;
}

/// The part of an exposure for which the disk hides a place, where `exposed(t)` is the part up to a time.
double hidden(const std::vector<Key>& keys, double x, double y,
              const std::function<double(double)>& exposed) {
  if (std::abs(y) >= kRadius) return 0;
  const double half = std::sqrt(kRadius * kRadius - y * y);
  double sum = 0;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const Key& a = keys[i];
    const Key b = i + 1 < keys.size() ? keys[i + 1] : Key{1, a.x};
    if (b.x == a.x) {
      if (std::abs(x - a.x) < half) sum += exposed(b.time) - exposed(a.time);
      continue;
    }
    // Times at which the middle is half a chord before and behind the place.
    const double speed = (b.x - a.x) / (b.time - a.time);
    double from = a.time + (x - half - a.x) / speed, to = a.time + (x + half - a.x) / speed;
    if (from > to) std::swap(from, to);
    from = std::clamp(from, a.time, b.time), to = std::clamp(to, a.time, b.time);
    sum += exposed(to) - exposed(from);
  }
  return sum;
}

double even(double t) { return std::clamp(t, 0.0, 1.0); }

// It turns back, and stands still after .8; times are multiples of 1 / 10.
const std::vector<Key> kWay = {{0, -0.6}, {0.3, 0.5}, {0.5, 0.1}, {0.8, 0.7}};

TEST(ShutterCoverage, OfKeysThatAreNotEvenlySpaced) {
  expect_coverage("", sliding(kWay), [](double x, double y, int) {
    const double half = std::sqrt(std::max(kRadius * kRadius - y * y, 0.0));
    // Pixels at the rim of where it stands.
    if (std::abs(std::abs(x - 0.7) - half) < 0.07) return std::nan("");
    return hidden(kWay, x, y, even);
  });
}

const std::vector<Key> kOneWay = {{0, -0.7}, {1, 0.5}};

TEST(ShutterCoverage, OfAShutterThatOpensAndCloses) {
  const double opening = 0.5, closing = 0.2, whole = 1 - (opening + closing) / 2;
  const auto exposed = [&](double t) {
    t = even(t);
    const double open = std::min(t, opening), last = std::max(t - (1 - closing), 0.0);
    return (open * open / (2 * opening) + std::max(t - opening, 0.0) - last * last / (2 * closing)) / whole;
  };
  ASSERT_NEAR(exposed(1), 1, 1e-12);
  expect_coverage("shutter { trapezoid { opening: 0.5 closing: 0.2 } }", sliding(kOneWay),
                  [&](double x, double y, int) { return hidden(kOneWay, x, y, exposed); });
}

TEST(ShutterCoverage, OfASampledCurve) {
  // Twice as far open in the second half, but for its beginning and end.
  const double values[] = {1, 0, 2, 2, 0};
  const auto exposed = [&](double t) {
    t = even(t);
    double sum = 0;
    for (int i = 0; i < 4; ++i) {
      const double x = std::clamp(4 * t - i, 0.0, 1.0);
      sum += (values[i] * x + (values[i + 1] - values[i]) * x * x / 2) / 4;
    }
    return sum / 1.125;
  };
  ASSERT_NEAR(exposed(1), 1, 1e-12);
  expect_coverage("shutter { sampled { values: [1, 0, 2, 2, 0] } }", sliding(kOneWay),
                  [&](double x, double y, int) { return hidden(kOneWay, x, y, exposed); });
}

TEST(ShutterCoverage, OfRowsThatAreExposedOneAfterTheOther) {
  const double duration = 0.3;
  for (const bool up : {false, true}) {
    const std::string shutter =
        absl::StrCat("shutter { rolling { direction: ", up ? "UP" : "DOWN", " duration: 0.3 } }");
    expect_coverage(shutter, sliding(kOneWay), [&](double x, double y, int row) {
      const double begin = (up ? kSide - 1 - row : row) / (kSide - 1.0) * (1 - duration);
      return hidden(kOneWay, x, y, [&](double t) { return even((t - begin) / duration); });
    });
  }
}

TEST(ShutterCoverage, OfColumnsByAShutterThatCloses) {
  // A column is exposed less and less.
  const double duration = 0.4;
  expect_coverage("shutter { sampled { values: [1, 0] } rolling { direction: LEFT duration: 0.4 } }",
                  sliding(kOneWay), [&](double x, double y, int) {
                    const double column = std::floor((x + 1) / 2 * kSide);
                    const double begin = (kSide - 1 - column) / (kSide - 1.0) * (1 - duration);
                    return hidden(kOneWay, x, y, [&](double t) {
                      const double s = even((t - begin) / duration);
                      return 2 * s - s * s;
                    });
                  });
}

TEST(ShutterCoverage, OfAWheelThatTurnsMoreThanOnce) {
  // A quarter of a disk that turns by 450 degrees, fast at first: 270 of them in the first half.
  const double first = 1.5 * std::numbers::pi, second = std::numbers::pi, quarter = std::numbers::pi / 2;
  expect_coverage(
      "",
      "disk { radius: 0.9 phi_max_degrees: 90 } motion { time: 0.5 turn { axis { z: 1 } degrees: 270 } } "
      "motion { time: 1 turn { axis { z: 2 } degrees: 180 } }",
      [&](double x, double y, int) {
        const double r = std::hypot(x, y);
        // Not at the rim, and not near the centre, where a pixel sees many angles.
        if (std::abs(r - 0.9) < 0.1 || r < 0.2) return std::nan("");
        if (r > 0.9) return 0.0;
        double angle = std::atan2(y, x);
        if (angle < 0) angle += 2 * std::numbers::pi;
        double sum = 0;
        // It covers from `turn` to a quarter more.
        for (int k = 0; k < 3; ++k) {
          const double last = angle + 2 * std::numbers::pi * k, from = last - quarter;
          sum += 0.5 * std::max(0.0, std::min(last, first) - std::max(from, 0.0)) / first;
          sum += 0.5 * std::max(0.0, std::min(last, first + second) - std::max(from, first)) / second;
        }
        return sum;
      });
}

/// A blade that turns and slides before the sky, and a camera that turns to the side.
std::string blade_scene(double turn, double x, double pan, const std::string& motion,
                        const std::string& camera) {
  const double a = turn * std::numbers::pi / 180, b = pan * std::numbers::pi / 180;
  return absl::StrFormat(
      "lights { infinite { radiance { constant: 1 } } } camera { perspective { fov_degrees: 50 } "
      "world_from_camera { elements: [%.15g,0,%.15g,0, 0,1,0,0, %.15g,0,%.15g,-4, 0,0,0,1] } %s } "
      "shapes { box { low: [-1.5, -0.3, -0.3] high: [1.5, 0.3, 0.3] } world_from_object { elements: "
      "[%.15g,%.15g,0,%.15g, %.15g,%.15g,0,0, 0,0,1,0, 0,0,0,1] } %s } ",
      std::cos(b), std::sin(b), -std::sin(b), std::cos(b), camera, std::cos(a), -std::sin(a), x, std::sin(a),
      std::cos(a), motion);
}

TEST(ShutterCoverage, OfRowsIsThatOfStillPicturesWhileTheyAreExposed) {
  // 300 degrees while the shutter is open.
  const double duration = 0.2;
  const std::string moves = blade_scene(
      0, -0.5, 0,
      "motion { time: 1 place { elements: [1,0,0,0.5, 0,1,0,0, 0,0,1,0, 0,0,0,1] } turn { axis { z: 1 } "
      "degrees: 300 } }",
      "motion { time: 1 turn { axis { y: 1 } degrees: 10 } } shutter { rolling { duration: 0.2 } }");
  std::vector<double> rolling(kSide * kSide);
  for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
    const std::vector<double> hits = hits_of_sky(moves, seed);
    ASSERT_FALSE(hits.empty());
    for (std::size_t i = 0; i < hits.size(); ++i) rolling[i] += hits[i];
  }
  // For each row 64 stills, one in the middle of each of as many equal parts of its exposure.
  constexpr std::uint32_t kStills = 64;
  constexpr double kTrials = double{kSamples} * kSeeds;
  std::vector<double> p_values;
  for (std::uint32_t row = 0; row < kSide; ++row) {
    const double begin = row / (kSide - 1.0) * (1 - duration);
    std::vector<double> stills(kSide);
    for (std::uint32_t i = 0; i < kStills; ++i) {
      const std::uint32_t number = row * kStills + i;
      const double t = begin + duration * (i + 0.5) / kStills;
      const std::vector<double> hits = hits_of_sky(blade_scene(300 * t, -0.5 + t, 10 * t, "", ""),
                                                   100 + number, kSamples * kSeeds / kStills, {row, row + 1});
      ASSERT_FALSE(hits.empty());
      for (std::size_t x = 0; x < kSide; ++x) stills[x] += hits[x];
    }
    for (std::size_t x = 0; x < kSide; ++x) {
      const double a = rolling[row * kSide + x] / kTrials, b = stills[x] / kTrials, p = (a + b) / 2;
      // 1e-3: in the time between two stills the blade goes over a seventh of a pixel, so that the midpoint
      // rule is off by an eighth of that over 64 where an edge enters a pixel or leaves it.
      p_values.push_back(interval_p_value(a - b, 1e-3, std::sqrt(std::max(2 * p * (1 - p), 1e-3) / kTrials)));
    }
  }
  expect_likely(p_values);
}

}  // namespace
}  // namespace tessera::test::shutter_coverage
