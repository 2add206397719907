// Warps: areas are kept, so a uniform grid of the square gives equal shares of the result.
#include "render/sampling/warp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

namespace tessera::render::TESSERA_ISA {
namespace {

/// Calls f(lanes of u) for the midpoints of an n x n grid; n is a multiple of 16.
template <class F>
void for_each_midpoint(int n, F&& f) {
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; x += kWidth) {
      const float step = 1.0f / static_cast<float>(n);
      f(Vec2{(to_float(Int::iota(x)) + 0.5f) * step, Float((static_cast<float>(y) + 0.5f) * step)});
    }
  }
}

constexpr int kGrid = 512;

/// Mean over the square of a function of the warped point.
double mean(const std::function<Float(Vec2)>& f) {
  double sum = 0;
  for_each_midpoint(kGrid, [&](Vec2 u) {
    const Float value = f(u);
    for (int l = 0; l < kWidth; ++l) sum += value.lane(l);
  });
  return sum / (double{kGrid} * kGrid);
}

// Midpoint rule on 512^2 points: smooth integrands to 1e-5, indicator functions to the edge's share of cells,
// 1 / 512.
constexpr double kSmooth = 2e-5, kEdge = 2e-3;

Float one_where(Mask m) { return select(m, Float(1.0f), Float(0.0f)); }

TEST(Warp, DiskIsUniform) {
  EXPECT_NEAR(mean([](Vec2 u) { return square_to_disk(u).x; }), 0, kSmooth);
  EXPECT_NEAR(mean([](Vec2 u) { return square_to_disk(u).y; }), 0, kSmooth);
  // The second moments of a uniform unit disk.
  EXPECT_NEAR(mean([](Vec2 u) { return sqr(square_to_disk(u).x); }), 0.25, kSmooth);
  EXPECT_NEAR(mean([](Vec2 u) { return sqr(square_to_disk(u).y); }), 0.25, kSmooth);
  EXPECT_NEAR(mean([](Vec2 u) { return one_where(square_to_disk_polar(u).radius < 0.3f); }), 0.09, kEdge);
  EXPECT_NEAR(mean([](Vec2 u) { return one_where(square_to_disk_polar(u).angle < 1.0f); }),
              (1 + kPi / 4) / (2 * kPi), kEdge);
  const Polar centre = square_to_disk_polar({Float(0.5f), Float(0.5f)});
  EXPECT_EQ(centre.radius.lane(0), 0);
  EXPECT_TRUE(std::isfinite(centre.angle.lane(0)));
}

TEST(Warp, CosineHemisphereFollowsTheCosine) {
  // The cosine falls to zero as a square root: the midpoint rule is off by the step to the power of 3/2,
  // 9e-5.
  EXPECT_NEAR(mean([](Vec2 u) { return square_to_cosine_hemisphere(u).z; }), 2.0 / 3, 9e-5);
  EXPECT_NEAR(mean([](Vec2 u) { return sqr(square_to_cosine_hemisphere(u).z); }), 0.5, kSmooth);
  EXPECT_NEAR(mean([](Vec2 u) { return length_squared(square_to_cosine_hemisphere(u)); }), 1, 1e-6);
  EXPECT_FLOAT_EQ(cosine_hemisphere_pdf(Float(0.5f)).lane(0), 0.5f * kInvPi);
  EXPECT_EQ(cosine_hemisphere_pdf(Float(-0.5f)).lane(0), 0);
}

TEST(Warp, SphereIsUniform) {
  for (const auto axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
    EXPECT_NEAR(mean([axis](Vec2 u) { return square_to_sphere(u).*axis; }), 0, kSmooth);
    EXPECT_NEAR(mean([axis](Vec2 u) { return sqr(square_to_sphere(u).*axis); }), 1.0 / 3, kSmooth);
    EXPECT_NEAR(mean([axis](Vec2 u) { return one_where(square_to_sphere(u).*axis > 0.6f); }), 0.2, kEdge);
  }
}

TEST(Warp, ConeIsUniformAtAnyWidth) {
  for (const float width : {1.0f, 1e-2f, 1e-6f, 1e-12f}) {
    // tan^2 of the angle to the axis, against its mean over the cone; 1 - cos itself would have no digits in
    // the direction.
    const auto squared_sine = [width](Vec2 u) {
      const Vec3 w = square_to_cone(u, width);
      return sqr(w.x * (1 / std::sqrt(width))) + sqr(w.y * (1 / std::sqrt(width)));
    };
    // With x = 1 - cos uniform in [0, width]: E[sin^2] = E[2 x - x^2] = width - width^2 / 3.
    EXPECT_NEAR(mean(squared_sine), 1 - width / 3, kSmooth) << width;
    EXPECT_FLOAT_EQ(cone_pdf(Float(width)).lane(0) * 2 * kPi * width, 1);
  }
}

TEST(Warp, TriangleIsUniform) {
  for (const auto b : {&Barycentric::b0, &Barycentric::b1, &Barycentric::b2}) {
    EXPECT_NEAR(mean([b](Vec2 u) { return square_to_triangle(u).*b; }), 1.0 / 3, kSmooth);
    EXPECT_NEAR(mean([b](Vec2 u) { return sqr(square_to_triangle(u).*b); }), 1.0 / 6, kSmooth);
    EXPECT_NEAR(mean([b](Vec2 u) { return one_where(square_to_triangle(u).*b < 0.0f); }), 0, 0);
    EXPECT_NEAR(mean([b](Vec2 u) { return one_where(square_to_triangle(u).*b > 0.5f); }), 0.25, kEdge);
  }
  EXPECT_NEAR(mean([](Vec2 u) {
                const Barycentric b = square_to_triangle(u);
                return b.b0 + b.b1 + b.b2;
              }),
              1, 1e-6);
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
