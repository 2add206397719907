#include "render/light/light_build.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <numbers>

#include "render/light/environment.h"
#include "render/light/light.h"

namespace tessera::render::TESSERA_ISA {
namespace {

using testing::HasSubstr;

constexpr double kPi64 = std::numbers::pi;
constexpr std::array<float, 3> kRadiance = {1, 2, 6};  // mean 3

Affine scaled(float x, float y, float z) { return {{x, 0, 0, 5, 0, y, 0, 6, 0, 0, z, 7}}; }

LightTable empty_table() {
  LightTable table;
  table.sources = light_sources();
  return table;
}

double power(const LightTable& table, const LightRecord& light) {
  return table.sources(light.kind).power(table, light);
}

/// A table with one quadric.
ShapeTable quadric_table(ShapeKind kind, const QuadricRecord& quadric) {
  ShapeTable shapes;
  ShapeRecord shape;
  shape.kind = kind;
  shapes.shapes = {shape};
  shapes.quadrics = {quadric};
  return shapes;
}

LightRecord only_light(ShapeTable shapes) {
  LightTable table = empty_table();
  append_area_lights(shapes, 0, kRadiance, false, -1, table);
  EXPECT_EQ(table.lights.size(), 1u);
  return table.lights.at(0);
}

TEST(AppendAreaLights, MakesALightOfEveryTriangle) {
  ShapeTable shapes;
  shapes.vertices = {{{0, 0, 0}}, {{2, 0, 0}}, {{3, 3, 0}}, {{1, 3, 0}}};
  shapes.triangles = {0, 1, 2, 0, 2, 3, 0, 0, 1};
  ShapeRecord shape;
  shape.triangle_count = 3;
  shapes.shapes = {shape};
  LightTable table = empty_table();
  table.lights.resize(2);
  append_area_lights(shapes, 0, kRadiance, true, -1, table);
  ASSERT_EQ(table.lights.size(), 5u);
  EXPECT_EQ(shapes.shapes[0].first_light, 2);
  for (int i = 0; i < 3; ++i) {
    const LightRecord& light = table.lights[static_cast<std::size_t>(2 + i)];
    EXPECT_EQ(light.kind, LightKind::kTriangle);
    EXPECT_EQ(light.primitive, i);
    EXPECT_EQ(light.two_sided, 1);
    EXPECT_FLOAT_EQ(light.area, i < 2 ? 3 : 0);
    EXPECT_EQ(light.radiance[2], 6);
    EXPECT_EQ(light.vertices[5],
              shapes.vertices[shapes.triangles[static_cast<std::size_t>(3 * i + 1)]].position[2]);
  }
}

TEST(AppendAreaLights, AShapeWhoseKindNoModelIsFor) {
  for (const ShapeKind kind : {ShapeKind::kCurves, ShapeKind::kSdfGrid, ShapeKind::kImplicit}) {
    ShapeTable shapes = quadric_table(kind, {});
    LightTable table = empty_table();
    append_area_lights(shapes, 0, kRadiance, false, -1, table);
    EXPECT_TRUE(table.lights.empty());
    EXPECT_EQ(shapes.shapes[0].first_light, -1);
  }
}

TEST(AppendAreaLights, VertexNormalsCountWhereTheyAreNotTheTriangles) {
  // Two triangles that would make a rectangle, with normals at their four corners.
  const auto lights_of = [](std::array<float, 3> first_normal, float pick) {
    ShapeTable shapes;
    shapes.vertices = {{{0, 0, 1}}, {{2, 0, 1}}, {{2, 3, 1}}, {{0, 3, 1}}};
    for (Vertex& vertex : shapes.vertices) vertex.normal[2] = 1;
    std::copy(first_normal.begin(), first_normal.end(), shapes.vertices[1].normal);
    shapes.triangles = {0, 1, 2, 0, 2, 3};
    ShapeRecord shape;
    shape.triangle_count = 2;
    shape.flags = kHasNormals;
    shapes.shapes = {shape};
    LightTable table = empty_table();
    append_area_lights(shapes, 0, kRadiance, false, -1, table, pick);
    EXPECT_EQ(table.any_interpolated, pick > 0 && first_normal[0] != 0);
    return table.lights;
  };
  // Flat ones, or a scene that does not ask: a rectangle as ever.
  for (const auto& lights : {lights_of({0, 0, 1}, 0.25f), lights_of({0.1f, 0, 1}, 0)}) {
    ASSERT_EQ(lights.size(), 2u);
    EXPECT_EQ(lights[0].kind, LightKind::kRectangle);
  }
  const std::vector<LightRecord> lights = lights_of({0.1f, 0, 1}, 0.25f);
  ASSERT_EQ(lights.size(), 2u);
  EXPECT_EQ(lights[0].kind, LightKind::kTriangle);
  EXPECT_EQ(lights[0].profile, kInterpolated);
  EXPECT_FLOAT_EQ(lights[0].tan_x, 0.25f);
  EXPECT_FLOAT_EQ(lights[0].tan_y, 6) << "of the whole mesh";
  EXPECT_EQ(lights[1].profile, kPlainProfile);
}

/// The lights of two triangles.
std::vector<LightRecord> two_lights(const std::vector<Vertex>& vertices,
                                    const std::vector<std::uint32_t>& triangles, std::int32_t texture = -1) {
  ShapeTable shapes;
  shapes.vertices.assign(vertices.begin(), vertices.end());
  shapes.triangles.assign(triangles.begin(), triangles.end());
  ShapeRecord shape;
  shape.triangle_count = 2;
  shapes.shapes = {shape};
  LightTable table = empty_table();
  table.lights.resize(1);
  append_area_lights(shapes, 0, kRadiance, false, texture, table);
  return {table.lights.begin() + 1, table.lights.end()};
}

TEST(AppendAreaLights, TwoTrianglesMakeARectangle) {
  const std::vector<Vertex> square = {{{0, 0, 1}}, {{2, 0, 1}}, {{2, 3, 1}}, {{0, 3, 1}}};
  for (const std::vector<std::uint32_t>& triangles : {std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3},
                                                      {1, 2, 0, 3, 0, 2},
                                                      {0, 1, 3, 1, 2, 3},
                                                      {0, 3, 2, 2, 1, 0}}) {
    const std::vector<LightRecord> lights = two_lights(square, triangles);
    ASSERT_EQ(lights.size(), 2u);
    EXPECT_EQ(lights[0].same_as, -1);
    EXPECT_EQ(lights[1].same_as, 1);
    for (const LightRecord& light : lights) {
      EXPECT_EQ(light.kind, LightKind::kRectangle);
      EXPECT_FLOAT_EQ(light.area, 6);
      // The front is where it was.
      const float* x = light.vertices + 3;
      const float* y = light.vertices + 6;
      EXPECT_FLOAT_EQ(x[0] * y[1] - x[1] * y[0], triangles[1] == 3 ? -1 : 1);
      EXPECT_FLOAT_EQ(light.direction[2], triangles[1] == 3 ? -1 : 1);
      EXPECT_FLOAT_EQ(light.tan_x * light.tan_y, 6);
    }
    EXPECT_EQ(lights[0].primitive, 0);
    EXPECT_EQ(lights[1].primitive, 1);
    LightTable table = empty_table();
    table.lights = lights;
    table.lights[1].same_as = 0;
    EXPECT_EQ(sampled_power(table, table.lights[1]), 0);
    EXPECT_EQ(selection_of_lights(table, LightSelection::kMixed).pmf, (std::vector<float>{1, 1}));
  }
}

TEST(AppendAreaLights, OtherPairsOfTrianglesStayApart) {
  const std::vector<Vertex> square = {{{0, 0, 1}}, {{2, 0, 1}}, {{2, 3, 1}}, {{0, 3, 1}}};
  const auto apart = [](const std::vector<LightRecord>& lights) {
    return lights[0].kind == LightKind::kTriangle && lights[1].kind == LightKind::kTriangle &&
           lights[1].same_as < 0;
  };
  EXPECT_FALSE(apart(two_lights(square, {0, 1, 2, 0, 2, 3})));
  EXPECT_TRUE(apart(two_lights(square, {0, 1, 2, 0, 2, 3}, 7)));  // a picture
  EXPECT_TRUE(apart(two_lights(square, {0, 1, 2, 0, 3, 2})));     // turned the other way
  EXPECT_TRUE(apart(two_lights(square, {0, 1, 2, 0, 1, 2})));     // twice the same
  std::vector<Vertex> kite = square, bent = square;
  kite[3].position[0] = 1e-3f;
  bent[3].position[2] = 1.001f;
  EXPECT_TRUE(apart(two_lights(kite, {0, 1, 2, 0, 2, 3})));
  EXPECT_TRUE(apart(two_lights(bent, {0, 1, 2, 0, 2, 3})));
}

TEST(AppendAreaLights, DescribesSpheres) {
  QuadricRecord q;
  q.radius = 2;
  q.z_min = -2;
  q.z_max = 2;
  q.render_from_object = scaled(3, 3, -3);
  const LightRecord round = only_light(quadric_table(ShapeKind::kSphere, q));
  EXPECT_FLOAT_EQ(round.radius, 6);
  EXPECT_FLOAT_EQ(round.area, static_cast<float>(4 * kPi64 * 36));
  EXPECT_EQ(round.position[1], 6);

  q.z_min = 0;
  q.partial = 1;
  const LightRecord half = only_light(quadric_table(ShapeKind::kSphere, q));
  EXPECT_EQ(half.radius, 0);
  EXPECT_FLOAT_EQ(half.area, static_cast<float>(2 * kPi64 * 36));

  // An oblate spheroid with axes a = 2, c = 1 has area 2 pi a^2 (1 + (1 - e^2) / e artanh e), e^2 = 3/4.
  q.radius = 1;
  q.z_min = -1;
  q.z_max = 1;
  q.partial = 0;
  q.render_from_object = scaled(2, 2, 1);
  const LightRecord flat = only_light(quadric_table(ShapeKind::kSphere, q));
  const double e = std::sqrt(0.75);
  EXPECT_EQ(flat.radius, 0);
  EXPECT_NEAR(flat.area, 8 * kPi64 * (1 + 0.25 / e * std::atanh(e)), 1e-3);
}

TEST(AppendAreaLights, DescribesDisks) {
  QuadricRecord q;
  q.radius = 2;
  q.inner_radius = 1;
  q.phi_max = static_cast<float>(kPi64);
  q.render_from_object = scaled(3, 0.5f, 9);
  EXPECT_FLOAT_EQ(only_light(quadric_table(ShapeKind::kDisk, q)).area,
                  static_cast<float>(kPi64 / 2 * 3 * 1.5));
}

LightRecord record(LightKind kind) {
  LightRecord light;
  light.kind = kind;
  std::copy(kRadiance.begin(), kRadiance.end(), light.radiance);
  return light;
}

TEST(LightPower, FollowsTheFormulas) {
  LightTable table = empty_table();
  table.scene_radius = 2;
  EXPECT_NEAR(power(table, record(LightKind::kPoint)), 4 * kPi64 * 3, 1e-5);
  EXPECT_NEAR(power(table, record(LightKind::kDistant)), 4 * kPi64 * 3, 1e-5);
  LightRecord light = record(LightKind::kSpot);
  light.cos_outer = 0.5f;
  light.cos_inner = 0.5f;
  EXPECT_NEAR(power(table, light), 2 * kPi64 * 0.5 * 3, 1e-5);
  light.cos_inner = 1;
  EXPECT_NEAR(power(table, light), 2 * kPi64 * 0.25 * 3, 1e-5);
  light = record(LightKind::kDisk);
  light.area = 7;
  EXPECT_NEAR(power(table, light), kPi64 * 7 * 3, 1e-4);
  light.two_sided = 1;
  EXPECT_NEAR(power(table, light), 2 * kPi64 * 7 * 3, 1e-4);

  table.environments.resize(1);
  light = record(LightKind::kInfinite);
  light.environment = 0;
  EXPECT_NEAR(power(table, light), 4 * kPi64 * 4 * kPi64 * 3, 1e-3);
}

TEST(SelectionOfLights, LiesBetweenPowerAndEvenness) {
  LightTable table = empty_table();
  table.lights = {record(LightKind::kPoint), record(LightKind::kPoint), record(LightKind::kPoint)};
  for (float& c : table.lights[1].radiance) c *= 99;
  for (float& c : table.lights[2].radiance) c = 0;
  const AliasTable selection = selection_of_lights(table, LightSelection::kMixed);
  // It would be 0.01 by power alone.
  EXPECT_GT(selection.pmf[0], 0.1f);
  EXPECT_LT(selection.pmf[0], 0.5f);
  EXPECT_FLOAT_EQ(selection.pmf[0] + selection.pmf[1], 1);
  EXPECT_EQ(selection.pmf[2], 0);
}

TEST(SelectionOfLights, TrianglesOfAShapeShareItsPart) {
  LightTable table = empty_table();
  table.lights = {record(LightKind::kPoint), record(LightKind::kDisk), record(LightKind::kDisk)};
  // Two parts of one shape, as bright together as the point light.
  for (const std::size_t i : {1, 2}) {
    table.lights[i].shape = 0;
    table.lights[i].area = 2;
  }
  const AliasTable selection = selection_of_lights(table, LightSelection::kMixed);
  EXPECT_NEAR(selection.pmf[0], 0.5f, 1e-6f);
  EXPECT_NEAR(selection.pmf[1], 0.25f, 1e-6f);
  EXPECT_NEAR(selection.pmf[2], 0.25f, 1e-6f);
}

TextureImage constant_image(std::int32_t width, std::int32_t height, float value) {
  TextureImage image;
  image.width = width;
  image.height = height;
  image.texels32.assign(static_cast<std::size_t>(width * height) * 4, value);
  return image;
}

TEST(BuildEnvironment, KeepsFluxAndInvertsTheTransform) {
  const Affine turned = {{0, -2, 0, 9, 2, 0, 0, 9, 0, 0, 2, 9}};
  for (const auto mapping :
       {EnvironmentMapping::kEqualAreaOctahedral, EnvironmentMapping::kLatitudeLongitude}) {
    const auto e = build_environment(constant_image(4, 4, 0.5f), mapping, 6, turned);
    ASSERT_TRUE(e.ok()) << e.status();
    EXPECT_NEAR(e->flux, 4 * kPi64 * 3, 1e-5);
    EXPECT_EQ(e->texels[0], 3);
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        float product = 0;
        for (int k = 0; k < 3; ++k) product += e->light_from_render.m[4 * r + k] * turned.m[4 * k + c];
        EXPECT_FLOAT_EQ(product, r == c ? 1 : 0);
      }
    }
  }
}

TEST(BuildEnvironment, LeavesTheMeanToBsdfSampling) {
  TextureImage image = constant_image(4, 4, 1);
  image.texels32[0] = image.texels32[1] = image.texels32[2] = 17;  // the mean is 2
  const auto e = build_environment(image, EnvironmentMapping::kEqualAreaOctahedral, 1, {}, true);
  ASSERT_TRUE(e.ok());
  EXPECT_FLOAT_EQ(e->sampled_share, 15.0f / 32);
  EXPECT_FLOAT_EQ(e->distribution.density[0], 16);
  EXPECT_EQ(e->distribution.density[1], 0);
  EXPECT_EQ(e->texels[4], 1);  // seen as it is

  // Where all is equal, or the same but for little, nothing is left to sample.
  image.texels32[0] = image.texels32[1] = image.texels32[2] = 1.1f;
  for (const TextureImage& even : {constant_image(4, 4, 1), image}) {
    const auto all = build_environment(even, EnvironmentMapping::kEqualAreaOctahedral, 1, {}, true);
    ASSERT_TRUE(all.ok());
    EXPECT_EQ(all->sampled_share, 0);
    LightTable table = empty_table();
    table.environments = {*all};
    table.lights.emplace_back().kind = LightKind::kInfinite;
    table.lights[0].environment = 0;
    const AliasTable selection = selection_of_lights(table, LightSelection::kMixed);
    EXPECT_TRUE(selection.threshold.empty());
    EXPECT_EQ(selection.pmf, std::vector<float>{0});
  }
}

TEST(BuildEnvironment, WeighsLatitudesBySolidAngle) {
  const auto e = build_environment(constant_image(2, 3, 1), EnvironmentMapping::kLatitudeLongitude, 1, {});
  ASSERT_TRUE(e.ok());
  // Bands of 60 degrees cover 1/4, 1/2, 1/4 of the sphere.
  EXPECT_FLOAT_EQ(e->distribution.marginal_cdf[1], 0.25f);
  EXPECT_FLOAT_EQ(e->distribution.marginal_cdf[2], 0.75f);
}

TEST(BuildEnvironment, ReadsBytesThroughTheirEncoding) {
  TextureImage image;
  image.width = image.height = 1;
  image.format = TexelFormat::kSrgb8;
  image.texels8 = {10u | 20u << 8 | 30u << 16 | 255u << 24};
  for (int i = 0; i < 256; ++i) image.decode[i] = static_cast<float>(i * i);
  const auto e = build_environment(image, EnvironmentMapping::kEqualAreaOctahedral, 2, {});
  ASSERT_TRUE(e.ok());
  EXPECT_EQ(e->texels[0], 200);
  EXPECT_EQ(e->texels[1], 800);
  EXPECT_EQ(e->texels[2], 1800);
}

TEST(BuildEnvironment, RefusesWhatCannotBe) {
  const auto message = [](const TextureImage& image, const Affine& a) {
    return std::string(
        build_environment(image, EnvironmentMapping::kEqualAreaOctahedral, 1, a).status().message());
  };
  EXPECT_THAT(message(constant_image(4, 2, 1), {}), HasSubstr("must be square, this one is 4 x 2"));
  EXPECT_THAT(message({}, {}), HasSubstr("empty"));
  EXPECT_THAT(message(constant_image(2, 2, 1), {{1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0}}),
              HasSubstr("singular"));
}

TEST(BuildEnvironment, DropsNegativeAndNonFiniteTexels) {
  TextureImage image = constant_image(2, 2, -1);
  image.texels32[0] = std::nanf("");
  image.texels32[4] = INFINITY;
  const auto e = build_environment(image, EnvironmentMapping::kEqualAreaOctahedral, 1, {});
  ASSERT_TRUE(e.ok());
  for (std::size_t i = 0; i < e->texels.size(); ++i) {
    EXPECT_EQ(e->texels[i], i % 4 == 3 ? 1 : 0);  // black, and with a uniform density beside it
  }
  EXPECT_EQ(e->flux, 0);
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
