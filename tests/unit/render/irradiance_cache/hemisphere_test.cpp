// Irradiance and its gradients from the cells of a hemisphere, against closed forms.
#include "render/textbook/irradiance_cache/hemisphere.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

namespace tessera::render::TESSERA_ISA::hemisphere {  // apart from tests that are compiled with these
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr int kSamples = 40'000;

using V = std::array<double, 3>;

struct Seen {
  double radiance, distance;
};
/// The light that is seen along a direction.
using World = std::function<Seen(const V& direction)>;

/// Rays through the middle of every cell.
Hemisphere::Estimate look_around(const World& world) {
  Hemisphere hemisphere(kSamples);
  for (int cell = 0; cell < hemisphere.cells(); ++cell) {
    const Vec3 d = hemisphere.direction(Int(cell), {Float(0.5f), Float(0.5f)});
    const Seen seen = world({double{d.x.lane(0)}, double{d.y.lane(0)}, double{d.z.lane(0)}});
    const auto radiance = static_cast<float>(seen.radiance);
    hemisphere.set(cell, {radiance, 2 * radiance, 0}, static_cast<float>(seen.distance));
  }
  return hemisphere.estimate();
}

// Cells are 1/112 of the squared sine high and 2 pi / 357 wide. A border that passes through cells is seen in
// steps of a cell: sums along it err by about a cell's part of the whole, 1/112, of each of the two borders
// of a lamp: 2 %, of which the tests allow one and a half as much.
constexpr double kTolerance = 0.03;

TEST(Hemisphere, LightFromEverywhereHasNoGradient) {
  const Hemisphere::Estimate e = look_around([](const V&) { return Seen{3, 5}; });
  EXPECT_NEAR(e.irradiance[0], 3 * std::numbers::pi, 1e-4);
  EXPECT_NEAR(e.irradiance[1], 6 * std::numbers::pi, 1e-4);
  EXPECT_EQ(e.irradiance[2], 0);
  EXPECT_NEAR(e.mean_distance, 5, 1e-4);
  for (int axis = 0; axis < 2; ++axis) {
    EXPECT_NEAR(e.rotation[0][axis], 0, 1e-3);
    EXPECT_NEAR(e.translation[0][axis], 0, 1e-3);
  }
}

TEST(Hemisphere, NothingAroundIsInfinitelyFar) {
  const Hemisphere::Estimate e = look_around([](const V&) { return Seen{1, kFar}; });
  EXPECT_EQ(e.mean_distance, kFar);
  EXPECT_EQ(e.translation[0][0], 0);
}

/// A wall of radiance 1 and height `height`, endless to both sides, that begins `distance` away along +x.
World lit_wall(double distance, double height) {
  return [=](const V& d) {
    if (d[0] <= 0) return Seen{0, kFar};
    const double t = distance / d[0];
    return d[2] * t < height ? Seen{1, t} : Seen{0, kFar};
  };
}

TEST(Hemisphere, BesideALitWall) {
  for (const auto& [distance, height] : {std::pair{1.0, 1.0}, {0.5, 1.0}, {2.0, 1.0}, {1.0, 3.0}}) {
    const Hemisphere::Estimate e = look_around(lit_wall(distance, height));
    // The wall is seen up to an elevation of which the cosine is distance / slant.
    const double slant = std::hypot(distance, height), pi = std::numbers::pi;
    const double expected = pi / 2 * (1 - distance / slant);
    EXPECT_NEAR(e.irradiance[0], expected, kTolerance * expected);
    // Towards the wall it grows.
    const double slope = pi / 2 * height * height / (slant * slant * slant);
    EXPECT_NEAR(e.translation[0][0], slope, kTolerance * slope) << distance << " " << height;
    EXPECT_NEAR(e.translation[0][1], 0, kTolerance * slope);
    // Turned towards it, too: d/da of the irradiance of a strip up to elevation a0 is pi/2 sin(a0). The axis
    // of that turn is +y.
    const double turn = pi / 2 * height / slant;
    EXPECT_NEAR(e.rotation[0][1], turn, kTolerance * turn) << distance << " " << height;
    EXPECT_NEAR(e.rotation[0][0], 0, kTolerance * turn);
    EXPECT_NEAR(e.rotation[1][1], 2 * turn, 2 * kTolerance * turn);
  }
}

// A disk of radius 1 and radiance 1, facing down, 1 above the plane; x is the distance from its axis.
double irradiance_under_disk(double x) {
  const double s = x * x + 2;
  return std::numbers::pi / 2 * (1 - x * x / std::sqrt(s * s - 4 * x * x));
}
World disk_lamp(double x) {
  return [=](const V& d) {
    const double t = 1 / d[2];
    return std::hypot(x + d[0] * t, d[1] * t) < 1 ? Seen{1, t} : Seen{0, kFar};
  };
}

TEST(Hemisphere, UnderADiskLamp) {
  for (const double x : {0.0, 0.5, 1.0, 1.5, 2.5}) {
    const Hemisphere::Estimate e = look_around(disk_lamp(x));
    const double expected = irradiance_under_disk(x);
    EXPECT_NEAR(e.irradiance[0], expected, kTolerance * expected) << x;
    constexpr double kStep = 1e-4;
    const double slope = (irradiance_under_disk(x + kStep) - irradiance_under_disk(x - kStep)) / (2 * kStep);
    // Without the slope, on the axis, steps of the border's two sides must cancel.
    EXPECT_NEAR(e.translation[0][0], slope, kTolerance * std::max(std::abs(slope), expected)) << x;
    EXPECT_NEAR(e.translation[0][1], 0, kTolerance * expected) << x;
  }
}

TEST(Hemisphere, TurningAwayFromADiskLamp) {
  // Irradiance is the normal's product with the vector that sums the light of all directions, as long as all
  // of the lamp is above the horizon: its part along x, by a fine grid over the disk.
  const double x = 1.5;
  double sum = 0;
  constexpr int kGrid = 1000;
  for (int i = 0; i < kGrid; ++i) {
    for (int j = 0; j < kGrid; ++j) {
      const double u = (i + 0.5) / kGrid * 2 - 1, v = (j + 0.5) / kGrid * 2 - 1;
      if (u * u + v * v > 1) continue;
      const double square = (u - x) * (u - x) + v * v + 1;
      sum += (u - x) / (square * square) * 4 / (kGrid * kGrid);  // cosine at the lamp 1 / r, direction / r
    }
  }
  const Hemisphere::Estimate e = look_around(disk_lamp(x));
  EXPECT_NEAR(e.rotation[0][1], sum, kTolerance * std::abs(sum));
  EXPECT_NEAR(e.rotation[0][0], 0, kTolerance * std::abs(sum));
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA::hemisphere
