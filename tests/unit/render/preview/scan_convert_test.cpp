// Coverage of triangles on a film: every sample between triangles belongs to one of them.
#include "render/textbook/preview/scan_convert.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "render/textbook/preview/clip.h"

namespace tessera::render::TESSERA_ISA {
namespace {

constexpr int kSide = 32;

struct Point {
  std::int32_t x, y;
};

class Coverage {
 public:
  void add(Point a, Point b, Point c) {
    scan_convert({{a.x, b.x, c.x}, {a.y, b.y, c.y}, {1, 1, 1}}, kSide, kSide, [&](const Span& span) {
      for (int x = span.first; x <= span.last; ++x) ++counts_[static_cast<std::size_t>(span.row * kSide + x)];
    });
  }
  int at(int x, int y) const { return counts_[static_cast<std::size_t>(y * kSide + x)]; }

 private:
  std::vector<int> counts_ = std::vector<int>(kSide * kSide);
};

/// Corners of a polygon round about `centre`, in order.
std::vector<Point> around(Point centre, int corners, std::int32_t radius, std::mt19937& random) {
  std::vector<Point> points;
  std::uniform_real_distribution<double> place(0.3, 0.7);
  for (int i = 0; i < corners; ++i) {
    const double angle = (i + place(random)) / corners * 2 * std::numbers::pi;
    points.push_back({centre.x + static_cast<std::int32_t>(std::lround(radius * std::cos(angle))),
                      centre.y + static_cast<std::int32_t>(std::lround(radius * std::sin(angle)))});
  }
  return points;
}

TEST(ScanConvert, FansCoverEverySampleOnce) {
  std::mt19937 random(15);
  for (int run = 0; run < 400; ++run) {
    // In the film, on a sample, and far away; every second fan goes round the other way.
    std::uniform_int_distribution<std::int32_t> place(0, kSide * kSubPixels);
    Point centre{place(random), place(random)};
    if (run % 3 == 0) centre = {centre.x / kSubPixels * kSubPixels, centre.y / kSubPixels * kSubPixels};
    // All samples lie well within a circle of two films, even with corners cut off.
    const std::int32_t radius = run % 5 == 0 ? kGuard / 4 : 4 * kSide * kSubPixels;
    const std::vector<Point> rim = around(centre, 5 + run % 40, radius, random);
    Coverage coverage;
    for (std::size_t i = 0; i < rim.size(); ++i) {
      const Point &a = rim[i], &b = rim[(i + 1) % rim.size()];
      (run + static_cast<int>(i)) % 2 == 0 ? coverage.add(centre, a, b) : coverage.add(b, a, centre);
    }
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x)
        ASSERT_EQ(coverage.at(x, y), 1) << "fan " << run << " at " << x << "," << y;
    }
  }
}

TEST(ScanConvert, GridsWithCornersOnSamplesCoverEverySampleOnce) {
  // All sides run through samples: only the fill rule decides.
  Coverage coverage;
  constexpr std::int32_t kCell = 4 * kSubPixels;
  for (std::int32_t y = -kCell; y < kSide * kSubPixels + kCell; y += kCell) {
    for (std::int32_t x = -kCell; x < kSide * kSubPixels + kCell; x += kCell) {
      const Point a{x, y}, b{x + kCell, y}, c{x + kCell, y + kCell}, d{x, y + kCell};
      if ((x + y) / kCell % 2 == 0) {
        coverage.add(a, b, c), coverage.add(a, c, d);
      } else {
        coverage.add(a, b, d), coverage.add(d, c, b);
      }
    }
  }
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) ASSERT_EQ(coverage.at(x, y), 1) << x << "," << y;
  }
}

TEST(ScanConvert, CoversWhatThreeSidesInWholeNumbersCover) {
  std::mt19937 random(16);
  std::uniform_int_distribution<std::int64_t> near(-kSide * kSubPixels, 2 * kSide * kSubPixels),
      far(-kGuard, kGuard);
  for (int run = 0; run < 2000; ++run) {
    std::int64_t x[3], y[3];
    for (int i = 0; i < 3; ++i)
      x[i] = run % 2 ? near(random) : far(random), y[i] = run % 2 ? near(random) : far(random);
    std::int64_t area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
    Coverage coverage;
    coverage.add({std::int32_t(x[0]), std::int32_t(y[0])}, {std::int32_t(x[1]), std::int32_t(y[1])},
                 {std::int32_t(x[2]), std::int32_t(y[2])});
    if (area < 0) std::swap(x[1], x[2]), std::swap(y[1], y[2]);
    for (int row = 0; row < kSide; ++row) {
      for (int column = 0; column < kSide; ++column) {
        bool inside = area != 0;
        for (int i = 0; i < 3; ++i) {
          const int j = (i + 1) % 3;
          const std::int64_t dx = x[j] - x[i], dy = y[j] - y[i];
          const std::int64_t side = dx * (row * kSubPixels - y[i]) - dy * (column * kSubPixels - x[i]);
          inside = inside && (side > 0 || (side == 0 && (dy < 0 || (dy == 0 && dx > 0))));
        }
        ASSERT_EQ(coverage.at(column, row), inside ? 1 : 0) << "triangle " << run;
      }
    }
  }
}

TEST(ScanConvert, TrianglesWithoutAnAreaCoverNothing) {
  Coverage coverage;
  coverage.add({0, 0}, {0, 0}, {0, 0});
  coverage.add({0, 0}, {2560, 2560}, {5120, 5120});
  coverage.add({0, 512}, {5120, 512}, {2560, 512});
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) EXPECT_EQ(coverage.at(x, y), 0);
  }
}

TEST(ScanConvert, NearnessIsLinearOverTheTriangle) {
  // n = 1 + 2 x + 3 y, in pixels, at the corners and so everywhere; floats at the corners are rounded by
  // 2^-24 of at most 160.
  const FilmTriangle triangle{{0, 31 * kSubPixels, 0}, {0, 0, 31 * kSubPixels}, {1, 63, 94}};
  int rows = 0;
  scan_convert(triangle, kSide, kSide, [&](const Span& span) {
    ++rows;
    for (int x = span.first; x <= span.last; ++x)
      EXPECT_NEAR(span.nearness_at_0 + span.nearness_per_column * x, 1 + 2 * x + 3 * span.row, 1e-9);
  });
  EXPECT_GE(rows, 30);
}

TEST(Clip, KeepsWhatIsInFrontAndNear) {
  // One corner behind the eye, in perspective: x = X / w.
  ClipPolygon polygon;
  polygon.corners[0] = {0, 0, 2, 2};
  polygon.corners[1] = {4, 0, 2, 2};
  polygon.corners[2] = {0, 4, -2, -2};
  polygon.size = 3;
  clip(0.5f, 1e6, polygon);
  ASSERT_EQ(polygon.size, 4);
  for (int i = 0; i < polygon.size; ++i) EXPECT_GE(polygon.corners[i].depth, 0.5);
  // A side from depth 2 to -2 meets 0.5 at 3/8 of its length.
  bool found = false;
  for (int i = 0; i < polygon.size; ++i)
    found = found || (std::abs(polygon.corners[i].x) < 1e-12 && std::abs(polygon.corners[i].y - 1.5) < 1e-12);
  EXPECT_TRUE(found);
}

TEST(Clip, CutsASharedSideAtOnePoint) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> place(-3, 3);
  for (int run = 0; run < 1000; ++run) {
    const auto corner = [&] {
      const double w = place(random);
      return ClipCorner{place(random), place(random), w, w};
    };
    const ClipCorner a = corner(), b = corner(), c = corner(), d = corner();
    ClipPolygon one{{a, b, c}, 3}, other{{b, a, d}, 3};
    if ((a.depth >= 0.25) == (b.depth >= 0.25)) continue;
    clip(0.25f, 1e9, one);
    clip(0.25f, 1e9, other);
    int shared = 0;
    for (int i = 0; i < one.size; ++i) {
      for (int j = 0; j < other.size; ++j)
        shared += one.corners[i].x == other.corners[j].x && one.corners[i].y == other.corners[j].y;
    }
    // The end of the side that is in front, and the cut.
    EXPECT_EQ(shared, 2) << run;
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
