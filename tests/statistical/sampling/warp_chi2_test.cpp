// Do the warps give the densities that they promise, cell by cell? (Means are tested in tests/unit/render.)
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "render/sampling/sphere_map.h"
#include "render/sampling/warp.h"
#include "support/kernel/chi2.h"

namespace tessera::render::TESSERA_ISA {
namespace {

constexpr int kWarpSamples = 1 << 20;
constexpr int kTests = 9;

/// Counts of kWarpSamples points in cells; `cell(lane values)` of each.
std::vector<double> count(std::size_t cells, const std::function<Vec3(Vec2)>& warp,
                          const std::function<std::size_t(double, double, double)>& cell) {
  std::mt19937 random(3);
  std::vector<double> observed(cells);
  alignas(64) float u[kWidth], v[kWidth];
  for (int i = 0; i < kWarpSamples; i += kWidth) {
    for (int l = 0; l < kWidth; ++l) {
      u[l] = static_cast<float>(random() >> 8) * 0x1p-24f;
      v[l] = static_cast<float>(random() >> 8) * 0x1p-24f;
    }
    const Vec3 p = warp({Float::load(u), Float::load(v)});
    for (int l = 0; l < kWidth; ++l) ++observed[cell(p.x.lane(l), p.y.lane(l), p.z.lane(l))];
  }
  return observed;
}

/// Directions against a density over solid angle, which must integrate to 1.
void check_directions(const char* name, const std::function<Vec3(Vec2)>& warp,
                      const std::function<double(double, double, double)>& pdf) {
  const test::SphereGrid grid(32, 64);
  std::vector<double> expected(grid.size());
  double total = 0;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const double p = test::integrate_cell(pdf, grid.bounds(i));
    expected[i] = kWarpSamples * p;
    total += p;
  }
  EXPECT_NEAR(total, 1, 1e-3) << name;
  const auto observed = count(grid.size(), warp, [&](double x, double y, double z) {
    EXPECT_NEAR(x * x + y * y + z * z, 1, 2e-6);
    return grid.cell(x, y, z);
  });
  EXPECT_GT(test::chi_square_test(observed, expected).p_value, test::sidak_level(0.01, kTests)) << name;
}

TEST(WarpChi2, Directions) {
  check_directions(
      "sphere", [](Vec2 u) { return square_to_sphere(u); },
      [](double, double, double) { return std::numbers::inv_pi / 4; });
  check_directions(
      "cosine hemisphere", [](Vec2 u) { return square_to_cosine_hemisphere(u); },
      [](double, double, double z) { return cosine_hemisphere_pdf(Float(static_cast<float>(z))).lane(0); });
  check_directions(
      "octahedral", [](Vec2 u) { return direction_from_octahedral(u); },
      [](double, double, double) { return std::numbers::inv_pi / 4; });
  for (const float width : {0.5f, 1.75f}) {
    check_directions(
        "cone", [width](Vec2 u) { return square_to_cone(u, Float(width)); },
        [width](double, double, double z) {
          return z >= 1 - double{width} ? double{cone_pdf(Float(width)).lane(0)} : 0;
        });
  }
}

/// A narrow cone, where 1 - cosine has no digits in a direction: the angle to the axis, squared, and the
/// azimuth are uniform.
TEST(WarpChi2, NarrowCones) {
  for (const float width : {1e-4f, 1e-10f}) {
    constexpr int kRows = 32, kColumns = 32;
    const auto observed = count(
        kRows * kColumns, [width](Vec2 u) { return square_to_cone(u, Float(width)); },
        [&](double x, double y, double) {
          const double part =
              (x * x + y * y) / (2 * double{width} - double{width} * width);  // sin^2, of the largest
          const double turn = std::atan2(y, x) / (2 * std::numbers::pi) + 0.5;
          const int row = std::min(static_cast<int>(part * kRows), kRows - 1),
                    column = std::min(static_cast<int>(turn * kColumns), kColumns - 1);
          return static_cast<std::size_t>(row * kColumns + column);
        });
    const std::vector<double> expected(kRows * kColumns, double{kWarpSamples} / (kRows * kColumns));
    EXPECT_GT(test::chi_square_test(observed, expected).p_value, test::sidak_level(0.01, kTests)) << width;
  }
}

/// Squared radius and angle of a uniform point of the disk are uniform.
TEST(WarpChi2, Disk) {
  constexpr int kSide = 32;
  const auto observed = count(
      kSide * kSide,
      [](Vec2 u) {
        const Vec2 d = square_to_disk(u);
        return Vec3{d.x, d.y, Float(0.0f)};
      },
      [](double x, double y, double) {
        const int row = std::min(static_cast<int>((x * x + y * y) * kSide), kSide - 1);
        const int column =
            static_cast<int>((std::atan2(y, x) / (2 * std::numbers::pi) + 0.5) * kSide) % kSide;
        return static_cast<std::size_t>(row * kSide + column);
      });
  const std::vector<double> expected(kSide * kSide, double{kWarpSamples} / (kSide * kSide));
  EXPECT_GT(test::chi_square_test(observed, expected).p_value, test::sidak_level(0.01, kTests));
}

/// Cells of equal area in barycentrics: 1 - sqrt(1 - b1)... that is, (1 - b1)^2 and b2 / (1 - b1) are
/// uniform.
TEST(WarpChi2, Triangle) {
  constexpr int kSide = 32;
  const auto observed = count(
      kSide * kSide,
      [](Vec2 u) {
        const Barycentric b = square_to_triangle(u);
        return Vec3{b.b0, b.b1, b.b2};
      },
      [](double, double b1, double b2) {
        const int row = std::min(static_cast<int>((1 - b1) * (1 - b1) * kSide), kSide - 1);
        const int column = std::min(static_cast<int>(b2 / (1 - b1) * kSide), kSide - 1);
        return static_cast<std::size_t>(row * kSide + column);
      });
  const std::vector<double> expected(kSide * kSide, double{kWarpSamples} / (kSide * kSide));
  EXPECT_GT(test::chi_square_test(observed, expected).p_value, test::sidak_level(0.01, kTests));
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
