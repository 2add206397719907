// Lights alone.
#include "render/scene/light/light_builder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "photometry/sky/sky_map.h"
#include "render/light/light_source.h"
#include "render/scene/light/sky_light.h"
#include "render/scene/values/light_records.h"
#include "unit/render/scene/builder_inputs.h"

namespace tessera::render {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// Stands for the kernels' model of lights on disks.
class OneLightAShape final : public LightSource {
 public:
  OneLightAShape() : LightSource({}) {}
  double power(const LightTable&, const LightRecord&) const override { return 1; }
  LightBounds bounds(const LightTable&, const LightRecord&) const override { return {}; }
  void append(const ShapeTable&, const ShapeRecord&, const LightRecord& light, float,
              std::vector<LightRecord>& lights) const override {
    lights.push_back(light);
  }
};

const LightSource& source_of(LightKind) {
  static const OneLightAShape source;
  return source;
}

std::optional<LightKind> kind_on_shape(ShapeKind shape) {
  return shape == ShapeKind::kDisk ? std::optional(LightKind::kDisk) : std::nullopt;
}

class LightBuilderTest : public testing::Test {
 protected:
  LightBuilderTest() { textures_.add_noise("slide"); }
  absl::Status add(const std::string& lights, const wire::AlgorithmTraits& algorithm = kSurfacesAlone) {
    LightBuilder builder({space_, blobs_.source, algorithm, textures_}, table_);
    return builder.add_lights(message<v1::Scene>(lights).lights());
  }
  std::string refusal(const std::string& light, const wire::AlgorithmTraits& algorithm = kSurfacesAlone) {
    return std::string(add("lights { name: 'lamp' " + light + " }", algorithm).message());
  }
  /// That of a lamp in the shape of a disk.
  absl::Status add_area_light(const std::string& text) {
    const auto light = message<v1::AreaLight>(text);
    LightBuilder builder({space_, blobs_.source, kSurfacesAlone, textures_}, table_);
    return builder.add_area_lights({{1, &light, "shape 1 (disk)"}}, shapes_);
  }

  void SetUp() override {
    table_.sources = {&source_of, &kind_on_shape};
    shapes_.shapes.resize(2);
    shapes_.shapes[1].kind = ShapeKind::kDisk;
  }

  const RenderSpace space_ = render_space_about({1, 2, 3});
  BlobsInMemory blobs_;
  NamedTextures textures_;
  ShapeTable shapes_;
  LightTable table_;
};

TEST_F(LightBuilderTest, LightsThatMoveStandInTheirOwnSpaceToo) {
  ASSERT_EQ(
      add("lights { point { intensity { constant: 1 } } } lights { point { position { x: 5 } "
          "position_end { x: 7 } intensity { constant: 3 } radius: 0.1 } } lights { point { intensity { "
          "constant: 1 } position_end { } } }"),
      absl::OkStatus());
  ASSERT_EQ(table_.lights.size(), 3u);
  EXPECT_EQ(table_.lights[0].kind, LightKind::kPoint);
  EXPECT_EQ(table_.lights[2].kind, LightKind::kPoint);  // its way ends where it begins
  const LightRecord& light = table_.lights[1];
  EXPECT_EQ(light.kind, LightKind::kMovingSoft);
  EXPECT_EQ(light.profile, 1);
  ASSERT_NE(table_.moving, nullptr);
  EXPECT_THAT(table_.moving->motion_of_light, ElementsAre(-1, 0, -1));
  const LightRecord& own = table_.moving->still.lights[1];
  EXPECT_EQ(own.kind, LightKind::kSoftPoint);
  EXPECT_THAT(own.position, ElementsAre(0, 0, 0));
  ASSERT_EQ(table_.moving->steps.size(), 2u);
  EXPECT_EQ(table_.moving->steps[0].m[3], 4);
  EXPECT_EQ(table_.moving->steps[1].m[3], 6);
}

/// Map of a light at a step, from its own space to render space, which is about (1, 2, 3).
std::vector<float> step_of(const LightTable& table, std::size_t motion, int step) {
  const LightMotion& way = table.moving->motions[motion];
  const Affine& map = table.moving->steps[static_cast<std::size_t>(way.first_step + step)];
  return {map.m, map.m + 12};
}

TEST_F(LightBuilderTest, LightsGoThroughTheirKeys) {
  ASSERT_EQ(add("lights { point { position { x: 5 } intensity { constant: 1 } } "
                "motion { time: 0.5 place { elements: [1,0,0,2, 0,1,0,0, 0,0,1,0, 0,0,0,1] } } "
                "motion { time: 1 place { elements: [2,0,0,0, 0,2,0,1, 0,0,2,0, 0,0,0,1] } } }"),
            absl::OkStatus());
  ASSERT_NE(table_.moving, nullptr);
  EXPECT_EQ(table_.lights[0].kind, LightKind::kMovingPoint);
  EXPECT_THAT(step_of(table_, 0, 0), ElementsAre(1, 0, 0, 4, 0, 1, 0, -2, 0, 0, 1, -3));
  const int last = table_.moving->motions[0].segments;
  ASSERT_EQ(last % 2, 0);
  EXPECT_THAT(step_of(table_, 0, last / 2), ElementsAre(1, 0, 0, 6, 0, 1, 0, -2, 0, 0, 1, -3));
  // Twice as far from the origin, but no larger itself.
  EXPECT_THAT(step_of(table_, 0, last), ElementsAre(1, 0, 0, 9, 0, 1, 0, -1, 0, 0, 1, -3));
}

TEST_F(LightBuilderTest, LightsTurnAboutAnyPoint) {
  // From (5, 0, 0) on an arm of length 3 about (2, 0, 0), three quarters of a turn.
  ASSERT_EQ(
      add("lights { spot { position { x: 5 } target { x: 4 } intensity { constant: 1 } "
          "cone_angle_degrees: 20 } motion { time: 1 turn { axis { z: 1 } degrees: 270 about { x: 2 } } } }"
          "lights { distant { direction { x: 1 } irradiance { constant: 1 } } "
          "motion { time: 1 turn { axis { z: 1 } degrees: 270 about { x: 2 } } } }"),
      absl::OkStatus());
  ASSERT_NE(table_.moving, nullptr);
  const auto near = [](const std::vector<float>& expected) {
    return testing::Pointwise(testing::FloatNear(1e-6f), expected);
  };
  EXPECT_THAT(step_of(table_, 0, table_.moving->motions[0].segments),
              near({0, 1, 0, 2 - 1, -1, 0, 0, -3 - 2, 0, 0, 1, -3}));
  EXPECT_THAT(step_of(table_, 1, table_.moving->motions[1].segments),
              near({0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0}));
}

TEST_F(LightBuilderTest, FaultsOfKeysAreTold) {
  const std::string point = "point { position { x: 5 } intensity { constant: 1 } } ",
                    stretched = "place { elements: [1,0,0,0, 0,2,0,0, 0,0,1,0, 0,0,0,1] } }",
                    flat = "place { elements: [1,0,0,0, 0,1,0,0, 0,0,0,0, 0,0,0,1] } }";
  EXPECT_THAT(refusal(point + "motion { time: 0.5 } motion { time: 0.5 }"),
              HasSubstr("motion key 1: its time of 0.5 is not after"));
  EXPECT_THAT(refusal(point + "motion { time: 0.2 } motion { time: 0.5 " + stretched),
              HasSubstr("motion key 1: its transform changes angles between directions"));
  EXPECT_THAT(refusal(point + "motion { time: 0.2 " + flat), HasSubstr("motion key 0 is singular"));
  EXPECT_THAT(refusal("point { intensity { constant: 1 } position_end { x: 1 } } motion { time: 1 }"),
              HasSubstr("said twice"));
  EXPECT_THAT(refusal("sky { toward_sun { z: 1 } cie_type: 1 } motion { time: 1 }"),
              HasSubstr("a sky does not move"));
  // Projections have stretches as they have where they stand still.
  EXPECT_EQ(add("lights { projection { fov_degrees: 40 intensity { constant: 1 } } motion { time: 1 " +
                stretched + " }"),
            absl::OkStatus());
}

TEST_F(LightBuilderTest, APointStandsInRenderSpace) {
  ASSERT_EQ(add("lights { point { position { x: 5 } intensity { constant: 3 } } scale: 2 }"),
            absl::OkStatus());
  EXPECT_EQ(table_.lights[0].kind, LightKind::kPoint);
  EXPECT_THAT(table_.lights[0].position, ElementsAre(4, -2, -3));
  EXPECT_THAT(table_.lights[0].radiance, ElementsAre(6, 6, 6));
}

TEST_F(LightBuilderTest, ASpotHasAConeAndPerhapsASlide) {
  ASSERT_EQ(
      add(R"(lights { spot { target { z: 7 } cone_angle_degrees: 60 cone_delta_degrees: 15 falloff: LINEAR } }
                   lights { spot { target { z: 7 } up { y: 1 } cone_angle_degrees: 45 texture: 'slide' } })"),
      absl::OkStatus());
  EXPECT_THAT(table_.lights[0].direction, ElementsAre(0, 0, 1));
  EXPECT_FLOAT_EQ(table_.lights[0].cos_outer, 0.5f);
  EXPECT_FLOAT_EQ(table_.lights[0].cos_inner, std::sqrt(0.5f));
  EXPECT_EQ(table_.lights[0].profile, kLinearAngle);
  EXPECT_EQ(table_.lights[0].texture, -1);
  EXPECT_EQ(table_.lights[1].texture, *textures_.node("slide"));
  EXPECT_FLOAT_EQ(table_.lights[1].tan_x, 1);
  EXPECT_TRUE(table_.any_textures);
}

TEST_F(LightBuilderTest, PointsAndSpotsWithARadiusAreSoft) {
  ASSERT_EQ(add(R"(lights { point { radius: 0.5 } } lights { point { } }
                   lights { spot { target { z: 7 } cone_angle_degrees: 60 radius: 0.25 } })"),
            absl::OkStatus());
  EXPECT_EQ(table_.lights[0].kind, LightKind::kSoftPoint);
  EXPECT_EQ(table_.lights[0].radius, 0.5f);
  EXPECT_EQ(table_.lights[1].kind, LightKind::kPoint);
  EXPECT_EQ(table_.lights[2].kind, LightKind::kSoftSpot);
  EXPECT_EQ(table_.lights[2].radius, 0.25f);
  EXPECT_FLOAT_EQ(table_.lights[2].cos_outer, 0.5f);
}

TEST_F(LightBuilderTest, LightFromAllAroundIsFoundByBsdfsUnlessPathsStartAtLights) {
  const std::string sky = "lights { infinite { radiance { constant: 2 } } }";
  ASSERT_EQ(add(sky), absl::OkStatus());
  ASSERT_EQ(add(sky, kFromLights), absl::OkStatus());
  EXPECT_THAT(table_.infinite_lights, ElementsAre(0, 1));
  EXPECT_EQ(table_.environments[0].sampled_share, 0);
  EXPECT_EQ(table_.environments[1].sampled_share, 1);
  EXPECT_EQ(table_.lights[1].environment, 1);
}

TEST_F(LightBuilderTest, APortalIsAParallelogramInRenderSpace) {
  const char* portal =
      "infinite { portal { x: 1 } portal { x: 3 } portal { x: 3 y: 5 } portal { x: 1 y: 5 } }";
  ASSERT_EQ(add(absl::StrCat("lights { ", portal, " }")), absl::OkStatus());
  EXPECT_THAT(table_.environments[0].portal, ElementsAre(0, -2, -3, 2, 0, 0, 0, 5, 0));
  EXPECT_EQ(table_.environments[0].portal_area, 10);
  EXPECT_THAT(refusal("infinite { portal { x: 1 } }"), HasSubstr("a portal has four corners"));
  EXPECT_THAT(refusal("infinite { portal {} portal {} portal {} portal {} }"),
              HasSubstr("portal has no area"));
}

TEST_F(LightBuilderTest, AShapeKnowsItsLight) {
  ASSERT_EQ(add_area_light("radiance { constant: 3 } scale: 2 two_sided: true texture: 'slide'"),
            absl::OkStatus());
  ASSERT_EQ(table_.lights.size(), 1u);
  EXPECT_EQ(shapes_.shapes[1].first_light, 0);
  EXPECT_EQ(shapes_.shapes[0].first_light, -1);
  EXPECT_EQ(table_.lights[0].shape, 1);
  EXPECT_EQ(table_.lights[0].radiance[2], 6);
  EXPECT_TRUE(table_.lights[0].two_sided);
  EXPECT_EQ(table_.lights[0].kind, LightKind::kDisk);
  EXPECT_EQ(table_.lights[0].texture, *textures_.node("slide"));
}

TEST_F(LightBuilderTest, LightsAreChosenAsTheJobAsks) {
  ASSERT_EQ(
      add("lights { point { intensity { constant: 3 } } } lights { point { intensity { constant: 1 } } }"),
      absl::OkStatus());
  const float centre[3] = {0, 0, 0};
  const auto chosen = [&](const std::string& asked) {
    LightTable table = table_;
    build_light_selection(message<v1::Algorithms>(asked), centre, 1, table);
    return table;
  };
  EXPECT_FALSE(chosen("").tree.empty()) << "two lights are enough for one";
  EXPECT_FALSE(chosen("light_selection: LIGHT_SELECTION_TREE").tree.empty());
  EXPECT_TRUE(chosen("light_selection: LIGHT_SELECTION_MIXED").tree.empty());
  EXPECT_FALSE(chosen("light_selection: LIGHT_SELECTION_UNIFORM").selection.threshold.empty());
  EXPECT_TRUE(chosen("direct_light: DIRECT_LIGHT_BSDF light_selection: LIGHT_SELECTION_MIXED")
                  .selection.threshold.empty());
}

TEST_F(LightBuilderTest, NamesTheLightAtFault) {
  EXPECT_THAT(refusal(""), HasSubstr("light 0 (lamp): its kind is missing"));
  EXPECT_THAT(refusal("point { intensity { constant: inf } }"), HasSubstr("light 0 (lamp): colour: "));
  EXPECT_THAT(refusal("point {} scale: nan"), HasSubstr("its scale is not finite"));
  for (const char* const radius : {"-1", "nan", "inf"}) {
    EXPECT_THAT(refusal(absl::StrCat("point { radius: ", radius, " }")),
                HasSubstr("light 0 (lamp): its radius is negative or not finite"));
    EXPECT_THAT(refusal(absl::StrCat("spot { target { x: 1 } radius: ", radius, " }")),
                HasSubstr("its radius is negative or not finite"));
  }
  EXPECT_THAT(refusal("distant {}"), HasSubstr("it has no direction"));
  EXPECT_THAT(refusal("spot { target { x: 1 } cone_angle_degrees: 90 texture: 'slide' }"),
              HasSubstr("a cone angle below 90 degrees"));
  EXPECT_THAT(refusal("projection { fov_degrees: 180 }"), HasSubstr("its field of view"));
  EXPECT_THAT(refusal("projection { fov_degrees: 90 texture: 'x' }"), HasSubstr("no texture x"));
  EXPECT_THAT(refusal("goniometric { world_from_light { elements: [0,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1] } }"),
              HasSubstr("its transform is singular"));
  EXPECT_THAT(refusal("infinite { image { digest: 'x' path: 'sky.exr' } }"),
              HasSubstr("image 'sky.exr': there is no blob x"));
  EXPECT_TRUE(table_.lights.empty());
  const auto area = [&](const char* light) { return std::string(add_area_light(light).message()); };
  EXPECT_THAT(area("radiance { constant: nan }"), HasSubstr("shape 1 (disk): area light: radiance: "));
  EXPECT_THAT(area("scale: inf"), HasSubstr("area light: its scale is not finite"));
  EXPECT_THAT(area("texture: 'x'"), HasSubstr("area light: no texture x"));
  EXPECT_THAT(area("interpolated_normal_pick: 2"), HasSubstr("area light: a probability"));
}

/// Integral over all directions of the luminance of a map of equal cells, times the cosine with +z above the
/// horizon: radiances times 683 are luminances.
double horizontal_illuminance(const Environment& map) {
  double sum = 0;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const double up = photometry::direction_of_map((x + 0.5) / map.width, (y + 0.5) / map.height).up;
      sum += std::max(up, 0.0) * map.texels[static_cast<std::size_t>(4 * (y * map.width + x) + 1)];
    }
  }
  return 683 * sum * 4 * std::numbers::pi / (map.width * map.height);
}

TEST_F(LightBuilderTest, SkiesAreAMapAndASun) {
  ASSERT_TRUE(
      add("lights { sky { cie_type: 12 toward_sun { y: 3 z: 4 } diffuse_horizontal_illuminance: 12000 "
          "sun_normal_illuminance: 80000 resolution: 128 } }")
          .ok());
  ASSERT_EQ(table_.lights.size(), 2u);
  EXPECT_THAT(table_.infinite_lights, ElementsAre(0, 1));
  const Environment &sky = table_.environments[0], &sun = table_.environments[1];
  EXPECT_EQ(sky.width, 128);
  // Middles of cells instead of means over them, and the ground in cells on the horizon.
  EXPECT_NEAR(horizontal_illuminance(sky) / 12'000, 1, 1e-3);
  // The flux counts cells whole, the last of which is half lit: 32 rows instead of 31.5.
  EXPECT_EQ(sun.width, 1);
  EXPECT_NEAR(683 * sun.flux / 80'000, std::pow(32 / 31.5, 2), 1e-3);
  // +y of the column's space is towards the sun.
  EXPECT_NEAR(sun.render_from_light.m[1], 0, 1e-6);
  EXPECT_NEAR(sun.render_from_light.m[5], 0.6, 1e-6);
  EXPECT_NEAR(sun.render_from_light.m[9], 0.8, 1e-6);
}

TEST_F(LightBuilderTest, SunsOfSkiesMayBeParallelLight) {
  ASSERT_TRUE(
      add("lights { sky { cie_type: 12 toward_sun { y: 3 z: 4 } sun_normal_illuminance: 68300 sun_degrees: 0 "
          "sun_color { rgb { r: 1 g: 1 b: 0 } } resolution: 8 } scale: 0.5 }")
          .ok());
  ASSERT_EQ(table_.lights.size(), 2u);
  EXPECT_EQ(table_.lights[1].kind, LightKind::kDistant);
  EXPECT_NEAR(table_.lights[1].direction[2], -0.8, 1e-6);
  // 68,300 lx are 100 W/m^2, half of them, of a yellow with that luminance: 0.927831 of its red and green.
  EXPECT_NEAR(table_.lights[1].radiance[0], 50 / 0.927831, 1e-4);
  EXPECT_NEAR(table_.lights[1].radiance[1], 50 / 0.927831, 1e-4);
  EXPECT_EQ(table_.lights[1].radiance[2], 0);
}

TEST_F(LightBuilderTest, SkiesWithoutASunAreOneLight) {
  const std::string overcast =
      "lights { sky { cie_type: 16 diffuse_horizontal_illuminance: 9000 resolution: 16 } }";
  ASSERT_TRUE(add(overcast + " lights { distant { direction { z: 1 } irradiance { constant: 1 } } }").ok());
  ASSERT_EQ(table_.lights.size(), 2u);
  EXPECT_EQ(table_.lights[1].kind, LightKind::kDistant);
  EXPECT_EQ(records_of(message<v1::Scene>(overcast).lights(0)), 1);
  EXPECT_EQ(records_of(message<v1::Light>("sky { cie_type: 12 }")), 2);
  EXPECT_EQ(records_of(message<v1::Light>("point { }")), 1);
  EXPECT_TRUE(has_parallel_sun(message<v1::SkyLight>("cie_type: 12 sun_degrees: 0")));
  EXPECT_FALSE(has_parallel_sun(message<v1::SkyLight>("cie_type: 12")));
  EXPECT_FALSE(has_parallel_sun(message<v1::SkyLight>("cie_type: 1 sun_degrees: 0")));
}

TEST_F(LightBuilderTest, SkiesThatMakeNoSenseAreRefused) {
  EXPECT_THAT(refusal("sky { cie_type: 20 toward_sun { z: 1 } }"), HasSubstr("light 0 (lamp)"));
  EXPECT_THAT(refusal("sky { cie_type: 20 toward_sun { z: 1 } }"), HasSubstr("no CIE sky of type 20"));
  EXPECT_THAT(refusal("sky { cie_type: 5 toward_sun { z: 1 } sky_color { constant: 0 } }"),
              HasSubstr("sky_color has no luminance"));
  EXPECT_THAT(refusal("sky { cie_type: 5 toward_sun { z: 1 } } motion { time: 1 }"),
              HasSubstr("a sky does not move while the shutter is open"));
  EXPECT_THAT(refusal("sky { cie_type: 5 toward_sun { z: 1 } } amount { value: 3 unit: 'lx' }"),
              HasSubstr("not in an amount"));
}

}  // namespace
}  // namespace tessera::render
