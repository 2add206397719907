#include "import/geometry/transform.h"

#include <cmath>

#include "gtest/gtest.h"

namespace tessera::client {
namespace {

// Products of a few doubles of magnitude 1 to 10.
constexpr double kRounding = 1e-13;

void expect_near(const Imath::V3d& a, const Imath::V3d& b) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], kRounding) << i;
}

TEST(Transform, RotatesCounterClockwise) {
  expect_near(transformed_vector({1, 0, 0}, rotation(90, {0, 0, 1})), {0, 1, 0});
  expect_near(transformed_vector({0, 1, 0}, rotation(90, {5, 0, 0})), {0, 0, 1});
  expect_near(transformed_vector({1, 0, 0}, rotation(120, {1, 1, 1})), {0, 1, 0});
}

TEST(Transform, AppliesTheLeftFactorFirst) {
  expect_near(Imath::V3d(1, 1, 1) * (scaling(2, 2, 2) * translation(1, 0, 0)), {3, 2, 2});
  expect_near(Imath::V3d(1, 1, 1) * (translation(1, 0, 0) * scaling(2, 2, 2)), {4, 2, 2});
}

TEST(Transform, LooksAlongPositiveZ) {
  const auto camera_from_world = look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0});
  ASSERT_TRUE(camera_from_world.has_value());
  expect_near(Imath::V3d(0, 0, 0) * *camera_from_world, {0, 0, 5});
  // Seen from +z, +x is to the left in pbrt's left-handed camera space.
  expect_near(Imath::V3d(1, 2, 0) * *camera_from_world, {-1, 2, 5});
  EXPECT_FALSE(look_at({0, 0, 0}, {0, 0, 0}, {0, 1, 0}).has_value());
  EXPECT_FALSE(look_at({0, 0, 0}, {0, 3, 0}, {0, 1, 0}).has_value());
}

TEST(Transform, IsWrittenForColumnVectors) {
  v1::Matrix matrix;
  write_matrix(translation(5, 6, 7), matrix);
  ASSERT_EQ(matrix.elements_size(), 16);
  EXPECT_EQ(matrix.elements(3), 5);
  EXPECT_EQ(matrix.elements(11), 7);
  EXPECT_EQ(matrix.elements(12), 0);
  write_matrix(Imath::M44d(), matrix);
  EXPECT_TRUE(matrix.elements().empty());
}

TEST(Transform, InvertsWhatCanBeInverted) {
  const Imath::M44d t = scaling(-1, 2, 0.5) * rotation(30, {1, 2, 3}) * translation(1, 2, 3);
  const auto back = inverse(t);
  ASSERT_TRUE(back.has_value());
  expect_near(Imath::V3d(4, 5, 6) * (t * *back), {4, 5, 6});
  EXPECT_LT(determinant3(t), 0);
  EXPECT_FALSE(inverse(scaling(1, 0, 1)).has_value());
}

}  // namespace
}  // namespace tessera::client
