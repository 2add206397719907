// Motion through several keys, against closed forms.
#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "render/scene/placement/motion.h"
#include "render/scene/shape/object_part.h"

namespace tessera::render::motion_keys {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kTurn = 2 * std::numbers::pi;

Transform at_x(double x) { return Transform::translation({x, 0, 0}); }

Motion through(const Transform& start, const std::vector<Motion::Key>& keys) {
  auto m = Motion::through(start, keys);
  EXPECT_TRUE(m.ok()) << m.status();
  return m.ok() ? *m : Motion(start);
}

v1::Shape shape_of(const std::string& text) {
  v1::Shape shape;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &shape)) << text;
  return shape;
}

std::string fault_of(const std::string& shape) {
  return std::string(Motion::of(shape_of(shape)).status().message());
}

/// Largest distance between where `m` takes `p` and where its linear pieces take it.
double deviation(const Motion& m, const Imath::V3d& p) {
  double most = 0;
  constexpr int kTimes = 8192;
  const int segments = m.segments();
  for (int i = 0; i < kTimes; ++i) {
    const double place = (i + 0.5) / kTimes * segments, before = std::floor(place), part = place - before;
    const Imath::V3d a = m.at(before / segments).apply(p), b = m.at((before + 1) / segments).apply(p);
    most = std::max(most, (a + part * (b - a) - m.at(place / segments).apply(p)).length());
  }
  return most;
}

TEST(MotionKeys, AreMetAtTheirTimesAndWaysBetweenThemAreStraight) {
  const Motion m = through(at_x(1), {{0.25, at_x(3)}, {0.5, at_x(2)}, {0.75, at_x(2)}});
  for (const auto& [time, x] : {std::pair{0.0, 1.0},
                                {0.125, 2.0},
                                {0.25, 3.0},
                                {0.375, 2.5},
                                {0.5, 2.0},
                                {0.6, 2.0},
                                {0.75, 2.0},
                                {0.9, 2.0},
                                {1.0, 2.0}}) {
    EXPECT_DOUBLE_EQ(m.at(time).m[3], x) << time;
  }
  EXPECT_TRUE(m.translates_only());
}

TEST(MotionKeys, AWheelTurnsAllTheWay) {
  // One turn and a half, as it rolls: on the road, the point below stands still.
  const double radius = 0.5, way = 1.5 * kTurn * radius;
  const Motion wheel =
      through(Transform{}, {{1, at_x(way), {.axis = {0, 0, 2}, .degrees = -540, .about = {0, 0, 0}}}});
  for (const double t : {0.0, 0.1, 1.0 / 3, 0.5, 0.9, 1.0}) {
    const Imath::V3d rim = wheel.at(t).apply({0, -radius, 0});
    const double angle = -1.5 * kTurn * t;
    EXPECT_NEAR(rim.x, way * t + radius * std::sin(angle), 1e-12) << t;
    EXPECT_NEAR(rim.y, -radius * std::cos(angle), 1e-12) << t;
  }
  EXPECT_FALSE(wheel.translates_only());
}

TEST(MotionKeys, TurnsGoOnFromKeyToKeyAboutTheirPoints) {
  // A quarter about z through (1, 0, 0), then a half about x through the origin.
  const Motion m = through(Transform{}, {{0.5, Transform{}, {{0, 0, 1}, 90, {1, 0, 0}}},
                                         {1, Transform{}, {{1, 0, 0}, 180, {0, 0, 0}}}});
  const Imath::V3d p(2, 0, 1);
  EXPECT_LT((m.at(0.5).apply(p) - Imath::V3d(1, 1, 1)).length(), 1e-12);
  EXPECT_LT((m.at(0.75).apply(p) - Imath::V3d(1, -1, 1)).length(), 1e-12);
  EXPECT_LT((m.at(1).apply(p) - Imath::V3d(1, -1, -1)).length(), 1e-12);
}

TEST(MotionKeys, TurnsGoWithinWhatIsPlaced) {
  // The placing stretches along x, after the turn.
  Transform place;
  place.m[0] = 3;
  const Motion m = through(place, {{1, place, {{0, 0, 1}, 360, {0, 0, 0}}}});
  EXPECT_LT((m.at(0.25).apply({1, 0, 0}) - Imath::V3d(0, 1, 0)).length(), 1e-12);
  EXPECT_LT((m.at(0.5).apply({1, 0, 0}) - Imath::V3d(-3, 0, 0)).length(), 1e-12);
}

TEST(MotionKeys, OfWhatIsReflectedArePlacedAsBefore) {
  Transform mirror;
  mirror.m[0] = -1;
  const Motion m =
      through(mirror, {{0.5, at_x(2) * mirror, {{0, 1, 1}, 100, {1, 2, 3}}}, {1, at_x(3) * mirror}});
  const auto reflected = m.of_reflected();
  ASSERT_TRUE(reflected.ok());
  for (const double t : {0.0, 0.2, 0.5, 0.8, 1.0}) {
    EXPECT_GT(reflected->at(t).determinant(), 0);
    EXPECT_LT((reflected->at(t).apply({-0.3, -0.4, -0.5}) - m.at(t).apply({0.3, 0.4, 0.5})).length(), 1e-12);
  }
}

TEST(MotionKeys, StepsHitThemWhereTheyCan) {
  EXPECT_EQ(through(at_x(0), {{0.5, at_x(5)}, {1, at_x(1)}}).segments(), 2);
  EXPECT_EQ(through(at_x(0), {{0.3, at_x(5)}, {1, at_x(1)}}).segments(), 10);
  const Motion thirds = through(at_x(0), {{1.0 / 3, at_x(5)}, {0.75, at_x(1)}});
  EXPECT_EQ(thirds.segments(), 12);
  EXPECT_LT(thirds.steps().error, 1e-5);
  // A bend that is none is not met.
  EXPECT_EQ(through(at_x(0), {{0.3, at_x(3)}, {1, at_x(10)}}).segments(), 1);
}

TEST(MotionKeys, TheErrorOfTheirStepsIsBounded) {
  const auto check = [](const Motion& m, const Imath::V3d& p, double size) {
    EXPECT_LT(deviation(m, p), m.steps().error * size * 1.01 + 1e-5 * size);
    EXPECT_GT(deviation(m, p), 0.2 * m.steps().error * size) << "the bound tells nothing";
  };
  // No number of even steps up to 128 hits these.
  const double odd[3] = {0.1234567, 0.4142135, 0.7320508};
  const Motion slides =
      through(at_x(0), {{odd[0], at_x(1)}, {odd[1], at_x(0.2)}, {odd[2], at_x(2)}, {1, at_x(1.5)}});
  check(slides, {0, 0, 0}, 1 + 0.8 + 1.8 + 0.5);
  // One turn and a half: chords of 540 / 128 degrees.
  const Motion wheel = through(Transform{}, {{1, Transform{}, {{0, 0, 1}, 540, {0, 0, 0}}}});
  EXPECT_EQ(wheel.segments(), Motion::kMostSegments);
  EXPECT_NEAR(wheel.steps().error, std::pow(1.5 * kTurn / 128, 2) / 8, 1e-7);
  check(wheel, {1, 0, 0}, 1);
  EXPECT_THAT(roughness_of(wheel.steps()), IsEmpty());
  // A turn that starts late has fewer of the steps.
  const Motion late =
      through(Transform{}, {{0.5, Transform{}}, {1, Transform{}, {{0, 0, 1}, 540, {0, 0, 0}}}});
  check(late, {1, 0, 0}, 1);
  EXPECT_THAT(roughness_of(late.steps()), HasSubstr("leave the way by up to 0.27 %"));
}

TEST(MotionKeys, OfProductsAreMet) {
  const Motion a = through(at_x(0), {{0.5, at_x(1)}}), b = through(at_x(0), {{1.0 / 3, at_x(1)}});
  EXPECT_EQ(steps_of_product(std::vector{a, b}).segments, 6);
  const Motion turns = through(Transform{}, {{1.0 / 3, Transform{}, {{0, 0, 1}, 20, {0, 0, 0}}}});
  const MotionSteps both = steps_of_product(std::vector{a, turns});
  EXPECT_EQ(both.segments, 126);
  EXPECT_LT(both.error, 1e-4);
  const ObjectPart part = ObjectPart{0, {}, {}}.placed_by(turns).placed_by(Motion(at_x(3))).placed_by(a);
  EXPECT_EQ(part.steps().segments, 126);
  EXPECT_LT((part.at(0.25).apply({0, 0, 0}) - Imath::V3d(3.5, 0, 0)).length(), 1e-12);
}

constexpr const char* kMirror = "place { elements: [-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1] }";
constexpr const char* kFlat = "place { elements: [1,0,0,0, 0,1,0,0, 0,0,0,0, 0,0,0,1] }";

TEST(MotionKeys, AllThatIsWrongIsTold) {
  EXPECT_THAT(fault_of("motion { time: 0 } motion { time: 0.5 } motion { time: 0.5 } motion { time: 1.5 }"),
              AllOf(HasSubstr("motion key 0: its time of 0 is not above 0"),
                    HasSubstr("motion key 2: its time of 0.5 is not after that of the key before, 0.5"),
                    HasSubstr("motion key 3: its time of 1.5 is not above 0, when the shutter opens, and at "
                              "most 1")));
  EXPECT_THAT(fault_of("motion { time: nan }"), HasSubstr("its time of nan"));
  EXPECT_THAT(
      fault_of(absl::StrCat("motion { time: 0.5 ", kMirror, " } motion { time: 0.7 ", kFlat,
                            " } motion { time: 1 place { elements: 3 } }")),
      AllOf(HasSubstr("its motion turns it inside out at motion key 0"),
            HasSubstr("its transform at motion key 1 is singular"), HasSubstr("motion key 2: a matrix")));
  EXPECT_THAT(fault_of("motion { time: 1 turn { degrees: 20 } }"),
              HasSubstr("motion key 0: the axis of its turn has no direction"));
  EXPECT_THAT(fault_of("motion { time: 1 turn { axis { z: 1 } degrees: inf } }"),
              HasSubstr("motion key 0: its turn is not finite"));
  EXPECT_THAT(fault_of("motion { time: 1 turn { axis { z: 1 } degrees: 3600 } }"),
              HasSubstr("its motion is followed by 128 steps at most"));
  EXPECT_THAT(fault_of("motion { time: 1 } world_from_object_end { elements: [1,0,0,1, 0,1,0,0, 0,0,1,0, "
                       "0,0,0,1] }"),
              HasSubstr("said twice"));
}

TEST(MotionKeys, AnEndIsOneKey) {
  const char* const end = "elements: [0,-1,0,2, 1,0,0,0, 0,0,1,0, 0,0,0,1]";
  const auto a = Motion::of(shape_of(absl::StrCat("world_from_object_end { ", end, " }"))),
             b = Motion::of(shape_of(absl::StrCat("motion { time: 1 place { ", end, " } }")));
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a->segments(), b->segments());
  for (const double t : {0.0, 0.3, 1.0}) EXPECT_EQ(a->at(t).m, b->at(t).m);
}

TEST(MotionKeys, WithoutAPlaceAreWhereTheKeyBeforeIs) {
  const auto m =
      Motion::of(shape_of("world_from_object { elements: [1,0,0,7, 0,1,0,0, 0,0,1,0, 0,0,0,1] } "
                          "motion { time: 0.5 } motion { time: 1 place {} }"));
  ASSERT_TRUE(m.ok());
  EXPECT_EQ(m->at(0.5).m[3], 7);
  EXPECT_EQ(m->at(0.75).m[3], 3.5);
  const auto still = Motion::of(shape_of("motion { time: 0.5 } motion { time: 1 }"));
  ASSERT_TRUE(still.ok());
  EXPECT_FALSE(still->moves());
}

}  // namespace
}  // namespace tessera::render::motion_keys
