#include "import/geometry/transform.h"

#include <cmath>

#include "gtest/gtest.h"

namespace tessera::client {
namespace {

// Products of a few doubles of magnitude 1 to 10.
constexpr double kRounding = 1e-13;

void expect_near(const Vector3& a, const Vector3& b) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], kRounding) << i;
}

TEST(Transform, RotatesCounterClockwise) {
  expect_near(rotation(90, {0, 0, 1}).apply_to_vector({1, 0, 0}), {0, 1, 0});
  expect_near(rotation(90, {5, 0, 0}).apply_to_vector({0, 1, 0}), {0, 0, 1});
  expect_near(rotation(120, {1, 1, 1}).apply_to_vector({1, 0, 0}), {0, 1, 0});
}

TEST(Transform, AppliesTheRightFactorFirst) {
  expect_near((translation(1, 0, 0) * scaling(2, 2, 2)).apply_to_point({1, 1, 1}), {3, 2, 2});
  expect_near((scaling(2, 2, 2) * translation(1, 0, 0)).apply_to_point({1, 1, 1}), {4, 2, 2});
}

TEST(Transform, LooksAlongPositiveZ) {
  const auto camera_from_world = look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0});
  ASSERT_TRUE(camera_from_world.has_value());
  expect_near(camera_from_world->apply_to_point({0, 0, 0}), {0, 0, 5});
  // Seen from +z, +x is to the left in pbrt's left-handed camera space.
  expect_near(camera_from_world->apply_to_point({1, 2, 0}), {-1, 2, 5});
  EXPECT_FALSE(look_at({0, 0, 0}, {0, 0, 0}, {0, 1, 0}).has_value());
  EXPECT_FALSE(look_at({0, 0, 0}, {0, 3, 0}, {0, 1, 0}).has_value());
}

TEST(Transform, InvertsWhatCanBeInverted) {
  const Transform t = translation(1, 2, 3) * rotation(30, {1, 2, 3}) * scaling(-1, 2, 0.5);
  const auto back = inverse(t);
  ASSERT_TRUE(back.has_value());
  expect_near((*back * t).apply_to_point({4, 5, 6}), {4, 5, 6});
  EXPECT_LT(t.determinant3(), 0);
  EXPECT_FALSE(inverse(scaling(1, 0, 1)).has_value());
}

}  // namespace
}  // namespace tessera::client
