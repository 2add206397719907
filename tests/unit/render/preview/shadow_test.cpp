// Light of a preview: shadow maps against shadow rays, penumbras and ambient light against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "render/textbook/whitted/whitted.h"
#include "unit/render/preview/preview_scene.h"

namespace tessera::render::TESSERA_ISA::preview_test {
namespace {

/// Renders with rays: one sample a pixel, through its middle but for 1e-6 of it.
wire::TileResult raycast_picture(const SceneContent& content, const SceneTables& tables) {
  wire::TileResult result = empty_picture(content.tables, 1);
  RenderStats stats;
  FixedTile film(result);
  Whitted whitted(IntegratorContext{tables, *content.rays, tables.sampler.seed, stats}, 1,
                  Whitted::Mirrors::kBlack);
  EXPECT_TRUE(whitted.render(film, film, {}));
  return result;
}

/// A room with boxes and a ball in it.
void add_room(SceneArrays& arrays) {
  add_rectangle(arrays, {-3, -1.5f, -3}, {6, 0, 0}, {0, 0, 6});
  add_rectangle(arrays, {-3, -3, 3}, {6, 0, 0}, {0, 6, 0});
  add_rectangle(arrays, {-3, -3, -3}, {0, 0, 6}, {0, 6, 0});
  add_rectangle(arrays, {0.2f, -1, 0}, {1, 0, 0.3f}, {0, 1, 0.2f});
  add_rectangle(arrays, {-1.4f, -1.2f, -0.5f}, {0.7f, 0.2f, 0}, {0, 0.5f, 0.8f});
  std::vector<Place> places;
  std::vector<std::uint32_t> triangles;
  constexpr std::uint32_t kAround = 48, kUp = 24;
  for (std::uint32_t j = 0; j <= kUp; ++j) {
    for (std::uint32_t i = 0; i <= kAround; ++i) {
      const double phi = 2 * std::numbers::pi * i / kAround, theta = std::numbers::pi * j / kUp;
      places.push_back({static_cast<float>(-0.6 + 0.6 * std::sin(theta) * std::cos(phi)),
                        static_cast<float>(0.3 + 0.6 * std::cos(theta)),
                        static_cast<float>(0.5 + 0.6 * std::sin(theta) * std::sin(phi))});
      if (i == kAround || j == kUp) continue;
      const std::uint32_t at = j * (kAround + 1) + i;
      for (const std::uint32_t corner :
           {at, at + 1, at + kAround + 2, at, at + kAround + 2, at + kAround + 1})
        triangles.push_back(corner);
    }
  }
  add_mesh(arrays, places, triangles);
}

/// The share of pixels, off the boundaries of shadows in either picture, that are alike to 1 %; the number of
/// those that are looked at is `compared`.
double agreement(const wire::TileResult& a, const wire::TileResult& b, int side, int& compared) {
  const auto value = [&](const wire::TileResult& picture, int x, int y) {
    return picture.values[picture.pixel_count() + static_cast<std::size_t>(y * side + x)];
  };
  // Shadows begin and end where a pixel is black beside one that is not.
  const auto flat = [&](const wire::TileResult& picture, int x, int y) {
    int black = 0;
    for (int dy = -2; dy <= 2; ++dy) {
      for (int dx = -2; dx <= 2; ++dx) black += value(picture, x + dx, y + dy) == 0;
    }
    return black == 0 || black == 25;
  };
  int same = 0;
  compared = 0;
  for (int y = 2; y < side - 2; ++y) {
    for (int x = 2; x < side - 2; ++x) {
      if (!flat(b, x, y)) continue;
      ++compared;
      same += std::abs(value(a, x, y) - value(b, x, y)) <= 0.01f * value(b, x, y);
    }
  }
  return double(same) / compared;
}

void expect_shadows_of_rays(const std::string& light, int fewest_dark) {
  SCOPED_TRACE(light);
  constexpr int kSide = 160;
  const auto content = build_kernel_scene(scene_text(light), kSide, &add_room);
  ASSERT_NE(content, nullptr);
  SceneTables tables = content->tables;
  tables.preview = {ShadowKind::kHard, 0};
  const wire::TileResult cast = raycast_picture(*content, tables), drawn = preview_picture(*content, tables);
  int compared = 0;
  EXPECT_GT(agreement(drawn, cast, kSide, compared), 0.99);
  EXPECT_GT(compared, kSide * kSide / 2);
  const auto dark = std::count(cast.values.begin(), cast.values.begin() + kSide * kSide, 0.0f);
  EXPECT_GT(dark, fewest_dark);
}

TEST(ShadowMap, HardShadowsAreThoseOfRays) {
  expect_shadows_of_rays("lights { point { position { x: 1.5 y: 2 z: -2 } intensity { constant: 20 } } }",
                         1000);
  expect_shadows_of_rays(
      "lights { spot { position { x: 1 y: 2 z: -3 } target { x: -0.3 y: 0 z: 0.5 } cone_angle_degrees: 40 "
      "cone_delta_degrees: 10 intensity { constant: 20 } } }",
      1000);
  expect_shadows_of_rays(
      "lights { distant { direction { x: -0.5 y: -1 z: 0.9 } irradiance { constant: 3 } } }", 1000);
}

TEST(ShadowMap, SurfacesDoNotShadowThemselves) {
  // A plane lit under ever flatter angles: no acne, by rays or maps of either kind.
  for (const float height : {2.0f, 0.3f, 0.05f}) {
    const auto content =
        build_kernel_scene(scene_text(absl::StrCat("lights { point { position { x: 0 y: ", -1 + height,
                                                   " z: 0 } intensity { constant: 20 } } }")),
                           96, [](SceneArrays& a) {
                             add_rectangle(a, {-30, -1, -30}, {60, 0, 0}, {0, 0, 60});
                           });
    ASSERT_NE(content, nullptr);
    SceneTables tables = content->tables;
    for (const ShadowKind kind : {ShadowKind::kHard, ShadowKind::kFiltered, ShadowKind::kSoft}) {
      tables.preview = {kind, 0};
      const wire::TileResult with = preview_picture(*content, tables);
      tables.preview.shadows = ShadowKind::kNone;
      const wire::TileResult without = preview_picture(*content, tables);
      EXPECT_EQ(with.values, without.values) << "height " << height << ", kind " << static_cast<int>(kind);
    }
  }
}

TEST(ShadowMap, PenumbrasAreAsWideAsTheLampAsks) {
  // A lamp of side 0.4 at height 2 above the floor, and a half-plane at height 1 whose edge is below its
  // middle: similar triangles make the penumbra 0.4 * 1 / 1 wide, from -0.2 to 0.2. A disk of the lamp's area
  // stands for the square, with a diameter of 0.4 * 2 / sqrt(pi) = 0.451. The camera looks down on it.
  const auto content = build_kernel_scene(
      "render_origin {} camera { orthographic {} world_from_camera { elements: [1,0,0,0, 0,0,-1,0.8, "
      "0,1,0,0, 0,0,0,1] } "
      "screen_window: [-0.5,0.5,-0.5,0.5] }"
      " film { width: 128 height: 128 filter { kind: BOX radius_x: 1e-6 radius_y: 1e-6 } }"
      " materials { name: 'paint' diffuse { reflectance { constant { constant: 0.5 } } } }",
      128, [](SceneArrays& a) {
        add_rectangle(a, {-5, 0, -5}, {10, 0, 0}, {0, 0, 10});
        add_rectangle(a, {0, 1, -5}, {5, 0, 0}, {0, 0, 10});
      });
  ASSERT_NE(content, nullptr);
  Lamp lamp;
  lamp.place[1] = 2;
  lamp.axis[1] = -1, lamp.axis[2] = 0;
  lamp.cone = kPi / 2;
  lamp.flat_area = 0.16f;
  lamp.radius = std::sqrt(0.16f / kPi);
  ShadowMap map(content->tables, lamp);
  Clusters clusters(content->arrays.shapes);
  clusters.fill(0, clusters.size());
  const std::vector<std::uint8_t> seen(content->arrays.shapes.shapes.size(), 1);
  const auto raster = std::make_unique<Raster>(content->tables, clusters, *content->rays);
  for (std::size_t face = 0; face < map.faces(); ++face) {
    Bins bins(clusters, content->arrays.shapes, projection_of(map.sensor(face), 1e-4f, 1));
    for (std::size_t i = 0; i < bins.pieces(); ++i) bins.find(i, seen);
    bins.sort();
    for (int row = 0; row < bins.rows(); ++row) {
      for (int column = 0; column < bins.columns(); ++column) {
        raster->render({map.sensor(face), bins, seen}, column, row);
        map.put(face, column, row, raster->nearness());
      }
    }
  }
  // Means over turned patterns, along x.
  const auto visible = [&](float x) {
    Float sum(0.0f);
    constexpr int kTurns = 64;
    for (int i = 0; i < kTurns; ++i) {
      const ShadowReceiver at{{Float(x), Float(0.0f), Float(0.0f)},
                              {Float(0.0f), Float(1.0f), Float(0.0f)},
                              (Float::iota() + static_cast<float>(i) * 16) * (2 * kPi / (16 * kTurns))};
      sum += map.visible(at, ShadowKind::kSoft, Mask::all());
    }
    double mean = 0;
    for (int lane = 0; lane < kWidth; ++lane) mean += double{sum.lane(lane)} / (kTurns * kWidth);
    return mean;
  };
  // The width of a ramp of the same variance as the derivative of a disk's: a disk of radius R has R^2 / 4
  // along an axis. From v = integral of (1 - F)... over even steps.
  double mean = 0, mean2 = 0;
  constexpr double kStep = 0.01;
  double before = visible(-0.6f);
  EXPECT_EQ(before, 1);
  for (double x = -0.6 + kStep; x < 0.6 + kStep / 2; x += kStep) {
    const double now = visible(static_cast<float>(x)), middle = x - kStep / 2;
    EXPECT_LE(now, before + 0.02) << "at " << x;  // it falls all the way, but for the taps' 1/16
    mean += (before - now) * middle;
    mean2 += (before - now) * middle * middle;
    before = now;
  }
  EXPECT_EQ(before, 0);
  const double width = 4 * std::sqrt(mean2 - mean * mean), expected = 2 * std::sqrt(0.16 / std::numbers::pi);
  // The blocker's depth is exact here, on one plane, and so is the filter's radius. The pattern's 16 points
  // have 16/16 of a disk's variance (r^2 = (i + 1/2) / 16); texels of 1/128 smear by less than 1 % of it.
  EXPECT_NEAR(width, expected, 0.04 * expected);
  EXPECT_NEAR(mean, 0, 0.01);
  // Twice as near to the floor, a blocker's shadow is a third as soft: (2 - 1.5) / 1.5; not measured here,
  // but PCF's is always sharp.
  const ShadowReceiver at{
      {Float(-0.1f), Float(0.0f), Float(0.0f)}, {Float(0.0f), Float(1.0f), Float(0.0f)}, Float(0.0f)};
  EXPECT_EQ(map.visible(at, ShadowKind::kFiltered, Mask::all()).lane(0), 1);
  EXPECT_EQ(map.visible(at, ShadowKind::kHard, Mask::all()).lane(0), 1);
}

TEST(Lighting, AmbientLightOfAnEvenSkyIsItsRadiance) {
  // White walls under a sky of radiance 0.7 send out albedo * 0.7, whichever way they face.
  const auto content = build_kernel_scene(scene_text("lights { infinite { radiance { constant: 0.7 } } }"),
                                          64, [](SceneArrays& a) { add_room(a); });
  ASSERT_NE(content, nullptr);
  SceneTables tables = content->tables;
  tables.preview = {ShadowKind::kSoft, 1};
  const wire::TileResult picture = preview_picture(*content, tables);
  for (std::size_t i = 0; i < picture.pixel_count(); ++i) {
    const float value = picture.values[picture.pixel_count() + i];
    const bool wall = std::abs(value - 0.35f) < 0.35f * 0.01f, sky = value == 0.7f;
    EXPECT_TRUE(wall || sky) << value;
  }
  tables.preview.ambient = 0;
  const wire::TileResult dark = preview_picture(*content, tables);
  for (std::size_t i = 0; i < dark.pixel_count(); ++i) {
    const float value = dark.values[dark.pixel_count() + i];
    EXPECT_TRUE(value == 0 || value == 0.7f) << value;
  }
}

TEST(Lighting, PatchesOfALampAddUpToIt) {
  // A strip of 32 x 1 of squares is cut into lamps that are no longer than they are wide, and none is lost.
  const auto content = build_kernel_scene(
      scene_text("shapes { disk { radius: 0.5 } material: 'paint' area_light { radiance { constant: 2 } } "
                 "world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,2, 0,0,0,1] } }"
                 "shapes { sphere { radius: 0.5 } material: 'paint' area_light { radiance { constant: 3 } } }"
                 "lights { point { position { x: 1 y: 2 z: 3 } intensity { constant: 5 } } }"
                 "lights { point { position { x: 1 y: 2 z: 3 } intensity { constant: 5 } radius: 0.3 } }"),
      8);
  ASSERT_NE(content, nullptr);
  const Lighting lighting = lighting_of(content->tables);
  ASSERT_EQ(lighting.lamps.size(), 4u);
  // Far from it, each is as bright as it is: pi r^2 L of the ball, that with the cosine of the disk, the
  // intensity.
  const Vec3 far{Float(0.0f), Float(0.0f), Float(100.0f)};
  const double area = std::numbers::pi * 0.25;
  for (const Lamp& lamp : lighting.lamps) {
    const LampLight light = light_of(content->tables, lamp, far, Mask::all());
    const double expected = lamp.light >= 0       ? 5 / (97.0 * 97 + 5)
                            : lamp.round_area > 0 ? 3 * area / 1e4
                                                  : 2 * area / (98.0 * 98);
    ASSERT_TRUE(all(light.lit));
    EXPECT_NEAR(light.irradiance.c[0].lane(0), expected, 1e-3 * expected);
    if (lamp.light >= 0) {
      // The same holds two radii from a soft one, which no highlight outshines.
      const LampLight near =
          light_of(content->tables, lamp, {Float(1.0f), Float(2.0f), Float(3.6f)}, Mask::all());
      EXPECT_NEAR(near.irradiance.c[0].lane(0), 5 / 0.36, 1e-3 * 5 / 0.36);
      if (lamp.radius > 0) {
        EXPECT_NEAR(near.most.lane(0), 5 / (std::numbers::pi * 0.09), 0.1);
      }
      EXPECT_EQ(lamp.radius, content->tables.lights.lights[static_cast<std::size_t>(lamp.light)].radius);
    }
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA::preview_test
