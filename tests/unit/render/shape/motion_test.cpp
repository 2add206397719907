// How placements change while the shutter is open, against closed forms.
#include "render/scene/placement/motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace tessera::render {
namespace {

using testing::HasSubstr;

Transform rotation_about_z(double angle) {
  Transform t;
  t.m[0] = t.m[5] = std::cos(angle);
  t.m[1] = -std::sin(angle);
  t.m[4] = std::sin(angle);
  return t;
}

Transform scaling(double x, double y, double z) {
  Transform t;
  t.m[0] = x, t.m[5] = y, t.m[10] = z;
  return t;
}

Motion motion(const Transform& start, const Transform& end) {
  auto m = Motion::between(start, end);
  EXPECT_TRUE(m.ok()) << m.status();
  return m.ok() ? *m : Motion(start);
}

double distance(const Transform& a, const Transform& b) {
  double most = 0;
  for (std::size_t i = 0; i < 12; ++i) most = std::max(most, std::abs(a.m[i] - b.m[i]));
  return most;
}

/// Largest distance between where `m` takes (1, 0, 0) and where its linear pieces take it.
double deviation(const Motion& m) {
  double most = 0;
  constexpr int kTimes = 4096;
  for (int i = 0; i < kTimes; ++i) {
    const double place = (i + 0.5) / kTimes * m.segments(), before = std::floor(place), part = place - before;
    const Imath::V3d a = m.at(before / m.segments()).apply({1, 0, 0}),
                     b = m.at((before + 1) / m.segments()).apply({1, 0, 0});
    const Imath::V3d c = m.at(place / m.segments()).apply({1, 0, 0});
    most = std::max(most, (a + part * (b - a) - c).length());
  }
  return most;
}

// 1e-13: some dozens of roundings of doubles near 1.
constexpr double kRounding = 1e-13;

TEST(Motion, TurnsAtConstantSpeed) {
  const Motion m = motion(rotation_about_z(0.3), rotation_about_z(1.7));
  for (const double t : {0.0, 0.1, 0.25, 0.5, 0.99, 1.0}) {
    EXPECT_LT(distance(m.at(t), rotation_about_z(0.3 + t * 1.4)), kRounding) << t;
  }
}

TEST(Motion, TurnsTheShorterWayRound) {
  const Motion m = motion(rotation_about_z(0), rotation_about_z(1.5 * std::numbers::pi));
  EXPECT_LT(distance(m.at(0.5), rotation_about_z(-0.25 * std::numbers::pi)), kRounding);
}

TEST(Motion, TranslationRotationAndStretchEachGoAtConstantSpeed) {
  const Transform start = Transform::translation({1, 2, 3}) * rotation_about_z(0.2) * scaling(1, 2, 3);
  const Transform end = Transform::translation({-1, 4, 3}) * rotation_about_z(1.0) * scaling(3, 2, 0.5);
  const Motion m = motion(start, end);
  const double t = 0.3;
  const Transform expected = Transform::translation({1 - 2 * t, 2 + 2 * t, 3}) *
                             rotation_about_z(0.2 + 0.8 * t) * scaling(1 + 2 * t, 2, 3 - 2.5 * t);
  EXPECT_LT(distance(m.at(t), expected), kRounding);
  EXPECT_LT(distance(m.at(0), start), kRounding);
  EXPECT_LT(distance(m.at(1), end), kRounding);
}

TEST(Motion, MirrorsStayMirrors) {
  // Both are a half turn away from themselves with all axes reversed, so that the rotation is that of the
  // proper parts.
  const Motion m = motion(scaling(1, 1, -1), rotation_about_z(1.0) * scaling(1, 1, -1));
  for (const double t : {0.0, 0.2, 0.5, 0.8, 1.0}) {
    EXPECT_LT(distance(m.at(t), rotation_about_z(t) * scaling(1, 1, -1)), kRounding) << t;
  }
}

TEST(Motion, IsNeverFlatInBetween) {
  // A half turn: linear interpolation of the matrices would be flat half way.
  const Motion m = motion(scaling(1, 2, 1), rotation_about_z(std::numbers::pi) * scaling(2, 1, 1));
  for (int i = 0; i <= 100; ++i)
    EXPECT_NEAR(m.at(i / 100.0).determinant(), (1 + i / 100.0) * (2 - i / 100.0), 1e-12);
}

TEST(Motion, StandsStillWithoutAnEnd) {
  const Motion m = motion(rotation_about_z(0.3), rotation_about_z(0.3));
  EXPECT_FALSE(m.moves());
  EXPECT_EQ(m.segments(), 0);
  EXPECT_EQ(m.at(0.7).m, rotation_about_z(0.3).m);
}

TEST(Motion, StraightWaysTakeOnePiece) {
  EXPECT_EQ(motion(Transform{}, Transform::translation({100, 0, 0})).segments(), 1);
  EXPECT_EQ(motion(rotation_about_z(0.4), Transform::translation({3, 0, 0}) * rotation_about_z(0.4))
                .steps()
                .segments,
            1);
  EXPECT_EQ(motion(Transform{}, scaling(1, 5, 1)).segments(), 1);
  EXPECT_TRUE(motion(Transform{}, Transform::translation({100, 0, 0})).translates_only());
  EXPECT_FALSE(motion(Transform{}, scaling(1, 5, 1)).translates_only());
}

TEST(Motion, PiecesStayCloseToTheArc) {
  for (const double angle : {1e-4, 0.01, 0.1, 0.5, 1.1})
    EXPECT_LT(deviation(motion(Transform{}, rotation_about_z(angle))), 1e-5) << angle;
  // Up to 128 pieces: (pi / 128)^2 / 8.
  EXPECT_LT(deviation(motion(Transform{}, rotation_about_z(std::numbers::pi))), 7.54e-5);
  EXPECT_EQ(motion(Transform{}, rotation_about_z(std::numbers::pi)).segments(), Motion::kMostSegments);
  // Turning and growing at once: of the radius half way, 1.5.
  EXPECT_LT(deviation(motion(Transform{}, rotation_about_z(0.01) * scaling(2, 2, 2))), 1.5e-5);
}

TEST(Motion, ExtremeSizesAreFine) {
  for (const double size : {1e-60, 1e60}) {
    const Motion m = motion(scaling(size, size, size), rotation_about_z(1) * scaling(size, size, size));
    EXPECT_LT(distance(m.at(0.5), rotation_about_z(0.5) * scaling(size, size, size)), kRounding * size);
  }
  const Motion thin = motion(scaling(1, 1, 1e-9), rotation_about_z(1) * scaling(1, 1, 1e-9));
  EXPECT_LT(distance(thin.at(0.5), rotation_about_z(0.5) * scaling(1, 1, 1e-9)), kRounding);
}

TEST(Motion, RefusesFlatAndMirroringOnes) {
  EXPECT_THAT(Motion::between(scaling(1, 1, 0), Transform{}).status().message(), HasSubstr("singular"));
  EXPECT_THAT(Motion::between(Transform{}, scaling(1, 1, 0)).status().message(), HasSubstr("singular"));
  EXPECT_THAT(Motion::between(Transform{}, scaling(1, 1, -1)).status().message(), HasSubstr("inside out"));
}

int segments_of(const std::vector<Motion>& motions) { return steps_of_product(motions).segments; }

TEST(Motion, ProductsOfTwoTurnsTakeAllPieces) {
  const Motion still(Transform{}), slides = motion(Transform{}, Transform::translation({1, 0, 0})),
                                   turns = motion(Transform{}, rotation_about_z(0.01));
  EXPECT_EQ(segments_of({still, turns}), turns.segments());
  EXPECT_EQ(segments_of({turns, still}), turns.segments());
  EXPECT_EQ(segments_of({slides, slides}), 1);
  EXPECT_EQ(segments_of({slides, turns}), Motion::kMostSegments);
}

TEST(Motion, StepsAreEvenlySpacedAndFinite) {
  std::vector<Affine> steps;
  ASSERT_TRUE(append_steps([](double t) { return Transform::translation({8 * t, 0, 0}); }, 4, steps).ok());
  ASSERT_EQ(steps.size(), 5u);
  for (std::size_t k = 0; k < 5; ++k) EXPECT_EQ(steps[k].m[3], 2 * static_cast<float>(k));
  EXPECT_FALSE(append_steps(
                   [](double t) {
                     return Transform::translation({1e300 * t, 0, 0});
                   },
                   1, steps)
                   .ok());
}

}  // namespace
}  // namespace tessera::render
