// Where shapes stand and how they move.
#include "render/scene/shape/instance_builder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "render/scene/shape/object_graph.h"
#include "render/shape/key_vertices.h"
#include "unit/render/scene/names_for_shapes.h"
#include "wire/mesh_blob.h"
#include "wire/packed_instances.h"

namespace tessera::render {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kIdentity = "elements: [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]";
constexpr const char* kFiveAlongX = "elements: [1,0,0,5, 0,1,0,0, 0,0,1,0, 0,0,0,1]";
constexpr const char* kSingular = "elements: [0,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]";

class InstanceBuilderTest : public NamesForShapes {
 protected:
  InstanceBuilderTest() {
    material_table_.materials.resize(1);
    blobs_.add("triangle", wire::encode_mesh({{0, 0, 0, 1, 0, 0, 0, 1, 0}, {}, {}, {0, 1, 2}}));
  }
  absl::Status build(const std::string& scene) {
    scene_ = message<v1::Scene>(scene);
    return builder_.build(scene_);
  }

  const RenderSpace space_ = render_space_about({1, 0, 0});
  v1::Scene scene_;
  InstanceBuilder builder_{space_, blobs_.source, shapes_, table_, warnings_};
};

TEST_F(InstanceBuilderTest, ShapesOfTheWorldStandInRenderSpace) {
  ASSERT_EQ(build(absl::StrCat("shapes { sphere { radius: 1 } world_from_object { ", kFiveAlongX, " } }")),
            absl::OkStatus());
  EXPECT_EQ(table_.world_shape_count, 1);
  EXPECT_EQ(table_.quadrics[0].render_from_object.m[3], 4);
  EXPECT_TRUE(table_.instances.empty());
}

TEST_F(InstanceBuilderTest, AnObjectIsBuiltOnceAndPlacedByItsInstances) {
  ASSERT_EQ(build(absl::StrCat(
                "objects { name: 'tree' shapes { sphere { radius: 1 } } shapes { disk { radius: 1 } } }"
                "instances { object: 'tree' } instances { object: 'tree' world_from_instance { ",
                kFiveAlongX, " } }")),
            absl::OkStatus());
  EXPECT_EQ(table_.world_shape_count, 0);
  ASSERT_EQ(table_.objects.size(), 1u);
  EXPECT_EQ(table_.objects[0].shape_count, 2);
  ASSERT_EQ(table_.instances.size(), 2u);
  EXPECT_EQ(table_.instances[0].render_from_instance.m[3], -1);
  EXPECT_EQ(table_.instances[1].render_from_instance.m[3], 4);
  EXPECT_EQ(table_.instances[1].instance_from_render.m[3], -4);
  EXPECT_THAT(shapes_.names(), ElementsAre("object 'tree', shape 0", "object 'tree', shape 1"));
}

TEST_F(InstanceBuilderTest, PackedInstancesFollowThoseThatHaveMessages) {
  blobs_.add("places", wire::encode_matrices(
                           {{1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0}, {2, 0, 0, 3, 0, 2, 0, 0, 0, 0, 2, 0}}));
  ASSERT_EQ(build("objects { name: 'a' shapes { sphere { radius: 1 } } }"
                  "objects { name: 'b' shapes { sphere { radius: 2 } } }"
                  "packed_instances { runs { object: 'b' count: 1 } runs { object: 'a' count: 1 } "
                  "matrices { digest: 'places' } } instances { object: 'a' }"),
            absl::OkStatus());
  ASSERT_EQ(table_.instances.size(), 3u);
  const auto expect = [&](std::size_t i, int object, float x, float scale) {
    EXPECT_EQ(table_.instances[i].object, object);
    EXPECT_EQ(table_.instances[i].number, static_cast<int>(i) + 1);
    EXPECT_EQ(table_.instances[i].render_from_instance.m[3], x);
    EXPECT_EQ(table_.instances[i].render_from_instance.m[0], scale);
  };
  expect(0, 0, -1, 1);
  expect(1, 1, 4, 1);
  expect(2, 0, 2, 2);
}

TEST_F(InstanceBuilderTest, MoreInstancesThanAreFlattenedAreHeldByOneObject) {
  constexpr std::size_t kMany = kMostFlattened + 1;
  std::vector<double> places;
  for (std::size_t i = 0; i < kMany; ++i)
    places.insert(places.end(), {1, 0, 0, static_cast<double>(i), 0, 1, 0, 0, 0, 0, 1, 0});
  blobs_.add("places", wire::encode_matrices({std::move(places)}));
  ASSERT_EQ(
      build(absl::StrCat("objects { name: 'a' shapes { sphere { radius: 1 } } shapes { half_space {} } }"
                         "packed_instances { runs { object: 'a' count: ",
                         kMany, " } matrices { digest: 'places' } }")),
      absl::OkStatus());
  ASSERT_EQ(table_.inner.size(), kMany);
  EXPECT_EQ(table_.inner[7].number, 8);
  EXPECT_EQ(table_.inner[7].render_from_instance.m[3], 6);
  // An object without end stands in the world by itself, and so does the object that holds all others.
  ASSERT_EQ(table_.instances.size(), kMany + 1);
  EXPECT_EQ(table_.instances[7].number, 8);
  const InstanceRecord& all = table_.instances.back();
  EXPECT_EQ(all.number, 0);
  EXPECT_EQ(all.render_from_instance.m[3], 0);
  EXPECT_EQ(table_.objects[static_cast<std::size_t>(all.object)].inner_count, static_cast<int>(kMany));
  EXPECT_THAT(builder_.note(), HasSubstr("the world's 524290 instances are kept as one level"));
}

TEST_F(InstanceBuilderTest, AnObjectFarFromItsOriginIsBuiltAboutItself) {
  ASSERT_EQ(build("objects { name: 'far' shapes { sphere { radius: 1 } world_from_object { "
                  "elements: [1,0,0,1000, 0,1,0,0, 0,0,1,0, 0,0,0,1] } } } instances { object: 'far' }"),
            absl::OkStatus());
  EXPECT_EQ(table_.quadrics[0].render_from_object.m[3], 0);
  EXPECT_EQ(table_.instances[0].render_from_instance.m[3], 999);
}

TEST_F(InstanceBuilderTest, WhatMovesIsAnObjectOfItsOwn) {
  const std::string moves = absl::StrCat("sphere { radius: 1 } world_from_object { ", kIdentity,
                                         " } world_from_object_end { ", kFiveAlongX, " }");
  ASSERT_EQ(build(absl::StrCat("shapes { ", moves, " name: 'ball' } shapes { ", moves,
                               " area_light {} name: 'lamp' } shapes { sphere { radius: 1 } }")),
            absl::OkStatus());
  EXPECT_EQ(table_.world_shape_count, 1);
  EXPECT_EQ(table_.objects.size(), 2u);
  ASSERT_EQ(table_.instances.size(), 2u);
  EXPECT_EQ(table_.instances[1].segments, 1);
  ASSERT_EQ(table_.motion_steps.size(), 4u);
  EXPECT_EQ(table_.motion_steps[0].m[3], -1);
  EXPECT_EQ(table_.motion_steps[1].m[3], 4);
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(InstanceBuilderTest, ManyMeshesThatMoveHaveKeys) {
  const std::string moves = absl::StrCat("mesh { blob { digest: 'triangle' } } world_from_object { ",
                                         kIdentity, " } motion { time: 1 place { ", kFiveAlongX, " } } ");
  std::string some;
  for (int i = 0; i < 8; ++i) absl::StrAppend(&some, "shapes { ", moves, " }");
  ASSERT_EQ(build(absl::StrCat(
                "shapes { ", moves, " area_light {} }", some,
                "shapes { mesh { blob { digest: 'triangle' } } motion { time: 0.5 turn { "
                "axis { z: 1 } degrees: 1.5 } } motion { time: 1 } }",
                "shapes { mesh { blob { digest: 'triangle' } } motion { time: 1 turn { axis { z: 1 } "
                "degrees: 90 } } }")),
            absl::OkStatus());
  // Lamps and meshes that many steps follow are objects.
  EXPECT_EQ(table_.instances.size(), 2u);
  ASSERT_EQ(table_.world_shape_count, 9);
  for (std::size_t i = 0; i < 8; ++i) {
    const ShapeRecord& shape = table_.shapes[i];
    EXPECT_TRUE(shape.flags & kDeforms);
    ASSERT_EQ(shape.key_segments, 1);
    float corners[3][3];
    corners_at(table_, shape, 0, 0.25f, corners);
    EXPECT_FLOAT_EQ(corners[0][0], -1 + 1.25f);
    EXPECT_FLOAT_EQ(corners[1][0], 1.25f);
    EXPECT_FLOAT_EQ(corners[2][1], 1);
  }
  const ShapeRecord& turned = table_.shapes[8];
  ASSERT_GT(turned.key_segments, 1);
  float corners[3][3];
  corners_at(table_, turned, 0, 1, corners);
  EXPECT_NEAR(corners[1][0], std::cos(1.5 * std::numbers::pi / 180) - 1, 1e-5);
  EXPECT_NEAR(corners[1][1], std::sin(1.5 * std::numbers::pi / 180), 1e-5);
}

TEST_F(InstanceBuilderTest, LargeMeshesThatMoveAreObjects) {
  std::string many;
  for (int i = 0; i < 9; ++i) {
    absl::StrAppend(
        &many,
        "shapes { mesh { blob { digest: 'triangle' size_bytes: 100000000 } } motion { time: 1 place { ",
        kFiveAlongX, " } } }");
  }
  ASSERT_EQ(build(many), absl::OkStatus());
  EXPECT_EQ(table_.world_shape_count, 0);
  EXPECT_EQ(table_.instances.size(), 9u);
}

TEST_F(InstanceBuilderTest, FewMeshesThatMoveAreObjects) {
  ASSERT_EQ(build(absl::StrCat("shapes { mesh { blob { digest: 'triangle' } } world_from_object_end { ",
                               kFiveAlongX, " } }")),
            absl::OkStatus());
  EXPECT_EQ(table_.world_shape_count, 0);
  EXPECT_EQ(table_.instances.size(), 1u);
}

TEST_F(InstanceBuilderTest, LeavesOutWhatIsFlat) {
  ASSERT_EQ(
      build(absl::StrCat("objects { name: 'o' shapes { sphere { radius: 1 } } } instances { object: 'o' "
                         "world_from_instance { ",
                         kSingular, " } }")),
      absl::OkStatus());
  EXPECT_TRUE(table_.instances.empty());
  EXPECT_THAT(warnings_, ElementsAre("instance 0 (o): its transform is singular; left out"));
}

TEST_F(InstanceBuilderTest, ARayMustReachEveryInstance) {
  ASSERT_EQ(build("objects { name: 'dust' shapes { sphere { radius: 1 } } } instances { object: 'dust' "
                  "world_from_instance { elements: [1e-12,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1] } }"),
            absl::OkStatus());
  const float centre[3] = {};
  EXPECT_EQ(builder_.check_reach(centre, 1e5f), absl::OkStatus());
  EXPECT_THAT(std::string(builder_.check_reach(centre, 1e7f).message()),
              HasSubstr("instance 0 (dust): its transform scales by more"));
}

class InstanceErrors : public InstanceBuilderTest,
                       public testing::WithParamInterface<std::pair<std::string, const char*>> {};

TEST_P(InstanceErrors, NameThePlace) {
  EXPECT_THAT(std::string(build(GetParam().first).message()), HasSubstr(GetParam().second));
}

INSTANTIATE_TEST_SUITE_P(
    All, InstanceErrors,
    testing::Values(
        std::pair("instances { object: 'x' }", "instance 0 (x): object 'x' does not exist"),
        std::pair("objects { name: 'o' } objects { name: 'o' }", "object 'o': the name is used twice"),
        std::pair("shapes { sphere { radius: -1 } name: 'ball' }", "shape 0 (ball): its radius"),
        std::pair("shapes { world_from_object { elements: 1 } }", "shape 0: a matrix has 1 elements"),
        std::pair("objects { name: 'o' shapes { disk {} } }", "object 'o', shape 0: its radius"),
        std::pair("objects { name: 'o' shapes { mesh { blob { digest: 'x' } } } }",
                  "object 'o', shape 0: mesh x: there is no blob x"),
        std::pair(absl::StrCat("shapes { sphere { radius: 1 } world_from_object_end { ", kSingular, " } }"),
                  "shape 0: its transform at the end of its motion is singular"),
        std::pair("objects { name: 'o' shapes { sphere { radius: 1 } } } instances { object: 'o' "
                  "world_from_instance { "
                  "elements: [1e30,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1] } }",
                  "instance 0 (o): its transform scales by more")));

TEST_F(InstanceBuilderTest, HalfSpacesOfObjectsWithinObjectsAreBounded) {
  // No level keeps them: forty levels that hold the one below twice would place 2^40.
  std::string levels = "objects { name: 'o0' shapes { half_space {} } } ";
  for (int i = 1; i <= 40; ++i)
    absl::StrAppend(&levels, "objects { name: 'o", i, "' instances { object: 'o", i - 1,
                    "' } instances { object: 'o", i - 1, "' } } ");
  EXPECT_THAT(
      std::string(build(levels + "instances { object: 'o40' }").message()),
      HasSubstr("half-spaces and lights of objects stand in the world one by one, here 1099511627776"));
}

TEST_F(InstanceBuilderTest, ObjectsWithinObjectsThatShareThemAreKeptAsLevels) {
  std::string levels = "objects { name: 'o0' shapes { sphere { radius: 1 } } } ";
  for (int i = 1; i <= 40; ++i)
    absl::StrAppend(&levels, "objects { name: 'o", i, "' instances { object: 'o", i - 1,
                    "' } instances { object: 'o", i - 1, "' } } ");
  ASSERT_EQ(build(levels + "instances { object: 'o40' }"), absl::OkStatus());
  EXPECT_LT(table_.inner.size() + table_.instances.size(), 1u << 19);
}

}  // namespace
}  // namespace tessera::render
