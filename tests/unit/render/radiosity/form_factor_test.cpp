// Form factors against closed forms [Howell, A Catalog of Radiation Heat Transfer Configuration Factors, C-11
// and C-14], from a point and by links.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "unit/render/radiosity/room.h"

namespace tessera::render::TESSERA_ISA::radiosity {
namespace {

constexpr double kPiD = std::numbers::pi;

/// Between opposite rectangles of sides a and b, c apart.
double parallel(double a, double b, double c) {
  const double x = a / c, y = b / c, x2 = 1 + x * x, y2 = 1 + y * y;
  return 2 / (kPiD * x * y) *
         (std::log(std::sqrt(x2 * y2 / (1 + x * x + y * y))) +
          x * std::sqrt(y2) * std::atan(x / std::sqrt(y2)) +
          y * std::sqrt(x2) * std::atan(y / std::sqrt(x2)) - x * std::atan(x) - y * std::atan(y));
}

/// From a rectangle of width `width` to one that stands on an edge of length `common`, `height` high.
double perpendicular(double height, double width, double common) {
  const double h = height / common, w = width / common, h2 = h * h, w2 = w * w;
  const double a = (1 + w2) * (1 + h2) / (1 + w2 + h2);
  const double b = std::pow(w2 * (1 + w2 + h2) / ((1 + w2) * (w2 + h2)), w2);
  const double c = std::pow(h2 * (1 + h2 + w2) / ((1 + h2) * (h2 + w2)), h2);
  return 1 / (kPiD * w) *
         (w * std::atan(1 / w) + h * std::atan(1 / h) -
          std::sqrt(h2 + w2) * std::atan(1 / std::sqrt(h2 + w2)) + std::log(a * b * c) / 4);
}

/// From square 0 to square 1 of a room, by links whose light is `error` times the source's at most wrong.
double linked_factor(const std::vector<Square>& squares, double error, std::size_t* count = nullptr) {
  const Room room(squares);
  std::vector<Brightness::Value> sides(room.surfaces().sides());
  for (const Side side : {4u, 6u}) sides[side] = {1, 1};
  const Links links = room.link(sides, {.error = error, .smallest_area = 1e-7});
  double sum = 0;
  for (const Link& link : links.links) {
    if (link.receiver.side() < 4 && !link.source.is_cluster())
      sum += room.surfaces().patch(link.receiver).area * link.factor;
  }
  if (count != nullptr) *count = links.links.size();
  return sum / (room.surfaces().area(0) + room.surfaces().area(2));
}

std::vector<Square> facing(double a, double b, double c) {
  return {{{0, 0, 0}, {a, 0, 0}, {0, b, 0}}, {{0, 0, c}, {0, b, 0}, {a, 0, 0}}};
}
std::vector<Square> cornered(double width, double height) {
  return {{{0, 0, 0}, {0, 1, 0}, {-width, 0, 0}}, {{0, 0, 0}, {0, 0, height}, {0, 1, 0}}};
}

TEST(FormFactor, OfParallelSquaresIsTheClosedForm) {
  ASSERT_NEAR(parallel(1, 1, 1), 0.199825, 1e-6);
  for (const double distance : {0.5, 1.0, 2.0}) {
    const double expected = parallel(1, 1, distance);
    EXPECT_NEAR(linked_factor(facing(1, 1, distance), 0.01 * expected), expected, 1e-3 * expected)
        << distance;
  }
}

TEST(FormFactor, OfPerpendicularSquaresIsTheClosedForm) {
  ASSERT_NEAR(perpendicular(1, 1, 1), 0.200044, 1e-6);
  for (const double height : {0.5, 1.0, 2.0}) {
    const double expected = perpendicular(height, 1, 1);
    EXPECT_NEAR(linked_factor(cornered(1, height), 0.02), expected, 1e-3 * expected) << height;
  }
}

TEST(FormFactor, IsReciprocal) {
  // The two sums share no point: each is off by its own quadrature, within 1e-3 as above.
  std::vector<Square> squares = cornered(0.7, 1.9);
  const double there = 0.7 * linked_factor(squares, 0.02);
  std::swap(squares[0], squares[1]);
  const double back = 1.9 * linked_factor(squares, 0.02);
  EXPECT_NEAR(there, back, 2e-3 * there);
}

TEST(FormFactor, OfAFinerBoundIsNearer) {
  const double expected = perpendicular(1, 1, 1);
  double last_error = 1;
  std::size_t last_count = 0;
  for (const double bound : {0.5, 0.1, 0.02}) {
    std::size_t count = 0;
    const double error = std::abs(linked_factor(cornered(1, 1), bound, &count) - expected);
    EXPECT_LT(error, last_error) << bound;
    EXPECT_GT(count, last_count) << bound;
    last_error = error;
    last_count = count;
  }
}

TEST(FormFactor, OfAPointToADiskOfTrianglesIsItsSolidAngle) {
  // A disk of half angle 45 degrees, straight above: sin^2 = 1/2, less what the triangles leave out of it.
  constexpr int kCorners = 256;
  const Vec x{0.3, -0.2, 0.1}, n{0, 0, 1};
  double sum = 0;
  for (int i = 0; i < kCorners; ++i) {
    const auto corner = [&](int k) {
      const double angle = 2 * kPiD * k / kCorners;
      return x + Vec{std::cos(angle), std::sin(angle), 1};
    };
    const Vec triangle[3] = {x + Vec{0, 0, 1}, corner(i), corner(i + 1)};
    sum += form_factor(x, n, above_horizon(x, n, triangle));
  }
  EXPECT_NEAR(sum, 0.5, 1e-4);
}

TEST(FormFactor, BelowTheHorizonIsCutOff) {
  // All around a point is 1, wherever the walls begin.
  const Room room(cube(0, 0));
  const Vec x{0.3, 0.4, 0.6}, n = vec64::unit({0.3, 0.5, -0.2});
  double sum = 0;
  for (Side side = 0; side < room.surfaces().sides(); side += 2) {
    const Patch patch = room.surfaces().patch(Name::of_side(side));
    sum += form_factor(x, n, above_horizon(x, n, patch.corner));
  }
  EXPECT_NEAR(sum, 1, 1e-12);
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA::radiosity
