#include "plot/isolines.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace tessera::client {
namespace {

template <class Value>
ValueGrid grid_with(std::size_t columns, std::size_t rows, Value&& value) {
  ValueGrid grid{columns, rows, {}};
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column)
      grid.values.push_back(value(static_cast<double>(column) + 0.5, static_cast<double>(row) + 0.5));
  }
  return grid;
}

// Values are |p - c|^2. A point of a line lies on a side of length 1 between two middles, where the values'
// linear course is the level r^2. A quadratic with second derivative 2 is at most 1/4 below its chord there:
// 0 <= r^2 - |p - c|^2 <= 1/4, so 0 <= r - |p - c| <= 1 / (4 (r + |p - c|)).
TEST(Isolines, OfAParaboloidAreCircles) {
  const double x = 20.3, y = 17.8;
  const ValueGrid grid =
      grid_with(41, 37, [&](double u, double v) { return (u - x) * (u - x) + (v - y) * (v - y); });
  for (const double radius : {2.0, 7.25, 12.0, 16.5}) {
    const std::vector<Isoline> lines = isolines(grid, radius * radius);
    ASSERT_EQ(lines.size(), 1u) << radius;
    EXPECT_TRUE(lines[0].closed);
    double turn = 0;
    for (std::size_t i = 0; i < lines[0].points.size(); ++i) {
      const PagePoint& p = lines[0].points[i];
      const PagePoint& q = lines[0].points[(i + 1) % lines[0].points.size()];
      const double distance = std::hypot(p.x - x, p.y - y);
      constexpr double kRounding = 1e-9;
      EXPECT_LE(distance, radius + kRounding);
      EXPECT_GE(distance, radius - 0.25 / (radius + distance) - kRounding);
      // Right of the way from p to q, where y grows downwards, lies (-(q.y - p.y), q.x - p.x).
      EXPECT_GT(-(q.y - p.y) * (p.x - x) + (q.x - p.x) * (p.y - y), 0)
          << "values grow outwards, on the right";
      turn += std::remainder(std::atan2(q.y - y, q.x - x) - std::atan2(p.y - y, p.x - x), 2 * M_PI);
    }
    EXPECT_NEAR(std::abs(turn), 2 * M_PI, 1e-9) << "once around";
    // The line is a polygon whose corners are up to 1 / (4 (r + |p - c|)) within the circle and less than
    // sqrt(2) apart: its length is below that of the circle by less than 2 pi / (4 (2 r - 1/4)) for the
    // corners, and by less than 1/24 sqrt(2)^2 / r^2 of it for the chords.
    const double circle = 2 * M_PI * radius;
    EXPECT_LT(length_of(lines[0]), circle);
    EXPECT_GT(length_of(lines[0]), circle * (1 - 1 / (12 * radius * radius)) - 2 * M_PI / (8 * radius - 1));
  }
}

TEST(Isolines, EndAtTheOutermostMiddles) {
  const ValueGrid grid = grid_with(8, 5, [](double x, double) { return x; });
  const std::vector<Isoline> lines = isolines(grid, 3.75);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_FALSE(lines[0].closed);
  for (const PagePoint& point : lines[0].points) EXPECT_DOUBLE_EQ(point.x, 3.75);
  const auto [top, bottom] = std::ranges::minmax(lines[0].points, {}, &PagePoint::y);
  EXPECT_EQ(top.y, 0.5);
  EXPECT_EQ(bottom.y, 4.5);
  EXPECT_TRUE(isolines(grid, 0.5).empty()) << "all values are at least as large";
  EXPECT_TRUE(isolines(grid, 8).empty());
}

TEST(Isolines, GoTheWayOfTheMeanThroughASaddle) {
  const ValueGrid saddle{2, 2, {1, 0, 0, 1}};
  const auto passes_corner = [&](double level, double x, double y) {
    const std::vector<Isoline> lines = isolines(saddle, level);
    EXPECT_EQ(lines.size(), 2u);
    return std::ranges::any_of(lines, [&](const Isoline& line) {
      return std::ranges::all_of(line.points, [&](const PagePoint& p) {
        return std::abs(p.x - x) + std::abs(p.y - y) < 1;  // both points on sides of this corner
      });
    });
  };
  EXPECT_TRUE(passes_corner(0.4, 1.5, 0.5)) << "around the low corners: the middle, 0.5, is high";
  EXPECT_TRUE(passes_corner(0.4, 0.5, 1.5));
  EXPECT_TRUE(passes_corner(0.6, 0.5, 0.5)) << "around the high corners";
  EXPECT_TRUE(passes_corner(0.6, 1.5, 1.5));
}

TEST(Isolines, LeaveOutMissingValues) {
  ValueGrid grid = grid_with(9, 9, [](double x, double y) { return x + y; });
  grid.values[4 * 9 + 4] = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Isoline> lines = isolines(grid, 9.2);
  EXPECT_EQ(lines.size(), 2u) << "on both sides of the hole";
  for (const Isoline& line : lines) {
    for (const PagePoint& point : line.points) {
      EXPECT_TRUE(std::isfinite(point.x) && std::isfinite(point.y));
      EXPECT_GE(std::max(std::abs(point.x - 4.5), std::abs(point.y - 4.5)), 1 - 1e-9);
    }
  }
  EXPECT_TRUE(isolines({1, 1, {3}}, 2).empty());
  EXPECT_TRUE(isolines({0, 0, {}}, 2).empty());
}

TEST(Isolines, GridsAreReducedToMeans) {
  ValueGrid grid = grid_with(5, 3, [](double x, double y) { return x + 10 * y; });
  grid.values[0] = std::numeric_limits<double>::quiet_NaN();
  const ValueGrid small = reduced(grid, 2);
  ASSERT_EQ(small.columns, 3u);
  ASSERT_EQ(small.rows, 2u);
  EXPECT_DOUBLE_EQ(small.at(0, 0), (6.5 + 15.5 + 16.5) / 3) << "without the missing one";
  EXPECT_DOUBLE_EQ(small.at(1, 0), 3 + 10);
  EXPECT_DOUBLE_EQ(small.at(2, 1), 4.5 + 25) << "a corner of one cell";
}

}  // namespace
}  // namespace tessera::client
