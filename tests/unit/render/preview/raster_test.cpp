// The z-buffer against rays through the same places: one item buffer, but for places within rounding of an
// edge.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "unit/render/preview/preview_scene.h"

namespace tessera::render::TESSERA_ISA::preview_test {
namespace {

/// Corners are rounded to 1/256 of a pixel, so an edge is where it was within 1/512 in x and in y, and rays
/// that pass it 1/128 away see what is on its other side. Where the nearest of two surfaces changes within a
/// pixel (they cross), a ray beside sees the change, too. Returns the number of pixels that no such edge
/// explains.
int differences(const SceneTables& tables, const RayQuery& rays, int& explained) {
  const Items raster = items_by_raster(tables, rays), cast = items_by_rays(tables, rays);
  std::vector<Items> beside;
  for (const float dx : {-1 / 128.0f, 0.0f, 1 / 128.0f}) {
    for (const float dy : {-1 / 128.0f, 0.0f, 1 / 128.0f})
      beside.push_back(items_by_rays(tables, rays, dx, dy));
  }
  int wrong = 0;
  explained = 0;
  for (std::size_t i = 0; i < raster.shape.size(); ++i) {
    const auto same = [&](const Items& other) {
      return raster.shape[i] == other.shape[i] && raster.instance[i] == other.instance[i] &&
             (raster.shape[i] < 0 || raster.primitive[i] == other.primitive[i]);
    };
    if (same(cast)) continue;
    (std::any_of(beside.begin(), beside.end(), same) ? explained : wrong) += 1;
  }
  return wrong;
}

void expect_same_items(const SceneContent& content, double most_explained = 0.02) {
  int explained = 0;
  EXPECT_EQ(differences(content.tables, *content.rays, explained), 0);
  const int pixels = content.tables.sensor.width * content.tables.sensor.height;
  EXPECT_LE(explained, most_explained * pixels);
}

/// Triangles all about, also behind the camera and through it.
void add_soup(SceneArrays& arrays, int count, float size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> place(-3, 3), side(-size, size);
  std::vector<Place> places;
  std::vector<std::uint32_t> triangles;
  for (int i = 0; i < count; ++i) {
    const Place at{place(random), place(random), 1.7f * place(random)};
    for (int k = 0; k < 3; ++k) {
      triangles.push_back(static_cast<std::uint32_t>(places.size()));
      places.push_back({at[0] + side(random), at[1] + side(random), at[2] + side(random)});
    }
  }
  add_mesh(arrays, places, triangles);
}

TEST(Raster, SeesWhatRaysSee) {
  for (const char* camera :
       {"",
        "render_origin {} camera { orthographic {} world_from_camera { elements: [1,0,0,0, 0,1,0,0, "
        "0,0,1,-9, 0,0,0,1] } screen_window: [-2.5,2.5,-2.5,2.5] }"}) {
    for (const auto& [count, size] : {std::pair(30, 3.0f), {400, 0.5f}, {6000, 0.1f}}) {
      std::string text = scene_text();
      if (*camera) text = camera + text.substr(text.find(" film"));
      const auto content =
          build_kernel_scene(text, 100, [&](SceneArrays& a) { add_soup(a, count, size, 20); });
      ASSERT_NE(content, nullptr);
      SCOPED_TRACE(absl::StrCat(count, " triangles ", camera));
      // Small triangles have an edge near many pixels: with sides of 0.1, 2 pixels, each pixel has some three
      // edges through it, of which 1/256 of a pixel on each side is in doubt.
      expect_same_items(*content, 0.05);
    }
  }
}

TEST(Raster, ClipsTrianglesThatReachBehindTheCamera) {
  // A floor from far behind to far ahead, and a sheet whose one corner is nearly in the camera.
  const auto content = build_kernel_scene(scene_text(), 96, [](SceneArrays& a) {
    add_rectangle(a, {-1000, -1, -1000}, {2000, 0, 0}, {0, 0, 2000});
    add_mesh(a, {{0.01f, 0.005f, -3.99f}, {2, 2, -20}, {3, 0.5f, 5}}, {0, 1, 2});
    add_mesh(a, {{-0.5f, 0, -4}, {-0.4f, 0.3f, -4}, {-0.2f, 0.1f, -3.7f}}, {0, 1, 2});
  });
  ASSERT_NE(content, nullptr);
  expect_same_items(*content);
  const Items items = items_by_raster(content->tables, *content->rays);
  EXPECT_GT(std::count(items.shape.begin(), items.shape.end(), 0), 96 * 40);  // the floor, below the horizon
}

TEST(Raster, NearAndFarPlanesOfTheCameraClip) {
  const auto content =
      build_kernel_scene(scene_text(), 64, [](SceneArrays& a) { add_soup(a, 400, 0.7f, 21); });
  ASSERT_NE(content, nullptr);
  SceneTables tables = content->tables;
  tables.sensor.near_clip = 3.5f;
  int explained = 0;
  EXPECT_EQ(differences(tables, *content->rays, explained), 0);
  EXPECT_LE(explained, 64 * 64 / 20);
  // With a far plane: nothing beyond it has a depth.
  tables.sensor.far_clip = 5;
  tables.aovs.add(wire::HitAov::kDepth);
  const wire::TileResult picture = preview_picture(*content, tables, {v1::AOV_DEPTH});
  int seen = 0;
  for (std::size_t i = 0; i < picture.pixel_count(); ++i) {
    const float t = picture.values[4 * picture.pixel_count() + i];
    seen += t > 0;
    // From the near plane to the far one, along rays that go off the axis by 60 degrees' half diagonal.
    EXPECT_LE(t, 1.5f * 1.291f * 1.001f);
  }
  EXPECT_GT(seen, 100);
}

TEST(Raster, InstancesAndOtherShapesAreWhereRaysMeetThem) {
  const auto content = build_kernel_scene(
      scene_text(
          "shapes { sphere { radius: 0.8 } material: 'paint' world_from_object { elements: [1,0,0,0.5, "
          "0,1,0,0, 0,0,1,0, 0,0,0,1] } }"
          " shapes { cylinder { radius: 0.3 z_min: -1 z_max: 1 } material: 'paint' }"
          " objects { name: 'ball' shapes { sphere { radius: 0.4 } material: 'paint' }"
          " shapes { disk { radius: 0.9 } material: 'paint' } }"
          " instances { object: 'ball' world_from_instance { elements: [1,0,0,-1, 0,2,0,0.5, 0,0,1,1, "
          "0,0,0,1] } }"
          " instances { object: 'ball' world_from_instance { elements: [0.5,0,0,-1, 0,0.5,0,-1, 0,0,0.5,0, "
          "0,0,0,1] } }"),
      96, [](SceneArrays& a) { add_soup(a, 60, 0.6f, 22); });
  ASSERT_NE(content, nullptr);
  expect_same_items(*content);
}

TEST(Raster, TrianglesThatAreNoneAreNotSeen) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const auto content = build_kernel_scene(scene_text(), 48, [](SceneArrays& a) {
    add_rectangle(a, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  });
  ASSERT_NE(content, nullptr);
  const Items before = items_by_raster(content->tables, *content->rays);
  // The same with broken ones between: Embree's are the sound ones', which stay as they are.
  SceneArrays arrays;
  arrays.materials = content->arrays.materials;
  arrays.lights = content->arrays.lights;
  add_mesh(arrays,
           {{-1, -1, 0},
            {1, -1, 0},
            {1, 1, 0},
            {-1, 1, 0},
            {nan, 0, -1},
            {0, nan, -1},
            {inf, 0, -1},
            {0, 0, -inf},
            {0, 0, -1}},
           {0, 1, 2, 4, 5, 8, 6, 7, 8, 8, 8, 8, 0, 8, 4, 0, 2, 3, 0, 7, 2, 1, 6, 8});
  SceneTables tables(arrays);
  tables.sensor = content->tables.sensor;
  tables.filter = content->tables.filter;
  const Items after = items_by_raster(tables, *content->rays);
  for (std::size_t i = 0; i < before.shape.size(); ++i) {
    ASSERT_EQ(after.shape[i], before.shape[i]) << i;
    if (before.shape[i] < 0) continue;
    ASSERT_EQ(after.primitive[i], before.primitive[i] == 0 ? 0 : 5) << i;
  }
  EXPECT_GT(std::count(before.shape.begin(), before.shape.end(), 0), 300);
}

TEST(Raster, DepthIsThatOfRays) {
  const auto content = build_kernel_scene(
      scene_text(
          "shapes { sphere { radius: 0.8 } material: 'paint' world_from_object { elements: [1,0,0,0.5, "
          "0,1,0,0, 0,0,1,-1, 0,0,0,1] } }"),
      100, [](SceneArrays& a) {
        add_rectangle(a, {-1000, -1, -1000}, {2000, 0, 0}, {0, 0, 2000});
        add_soup(a, 100, 0.8f, 23);
      });
  ASSERT_NE(content, nullptr);
  SceneTables tables = content->tables;
  tables.aovs.add(wire::HitAov::kDepth);
  const wire::TileResult picture = preview_picture(*content, tables, {v1::AOV_DEPTH});
  const Items raster = items_by_raster(tables, *content->rays), cast = items_by_rays(tables, *content->rays);
  int compared = 0;
  for (std::size_t i = 0; i < picture.pixel_count(); ++i) {
    const float t = picture.values[4 * picture.pixel_count() + i];
    if (raster.shape[i] < 0) {
      EXPECT_EQ(t, 0);
      continue;
    }
    if (raster.shape[i] != cast.shape[i] || raster.primitive[i] != cast.primitive[i]) continue;
    ++compared;
    EXPECT_NEAR(t, cast.t[i], 1e-5f * cast.t[i]) << i;
  }
  EXPECT_GT(compared, 5000);
}

TEST(Raster, FilmsOfAnySizeAreCutIntoBins) {
  for (const std::uint32_t side : {1u, 31u, 33u, 65u}) {
    const auto content =
        build_kernel_scene(scene_text(), side, [](SceneArrays& a) { add_soup(a, 50, 1, 24); });
    ASSERT_NE(content, nullptr);
    SCOPED_TRACE(side);
    expect_same_items(*content, 0.05);
  }
}

TEST(Clusters, BoxesHoldTheirPrimitives) {
  const auto content = build_kernel_scene(scene_text(), 8, [](SceneArrays& a) { add_soup(a, 1000, 1, 25); });
  ASSERT_NE(content, nullptr);
  const ShapeTable& table = content->arrays.shapes;
  Clusters clusters(table);
  ASSERT_EQ(clusters.size(), (1000u + kClusterSize - 1) / kClusterSize);
  clusters.fill(0, clusters.size());
  for (std::size_t c = 0; c < clusters.size(); ++c) {
    const WideBox boxes = clusters.boxes(c);
    const float low[3] = {boxes.low.x.lane(0), boxes.low.y.lane(0), boxes.low.z.lane(0)},
                high[3] = {boxes.high.x.lane(0), boxes.high.y.lane(0), boxes.high.z.lane(0)};
    float least[3] = {INFINITY, INFINITY, INFINITY}, most[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (int i = 0; i < 3 * clusters.primitives(0, c); ++i) {
      const float* const p =
          table.vertices[table.triangles[c * kClusterSize * 3 + static_cast<std::size_t>(i)]].position;
      for (int k = 0; k < 3; ++k) least[k] = std::min(least[k], p[k]), most[k] = std::max(most[k], p[k]);
    }
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(low[k], least[k]);
      EXPECT_EQ(high[k], most[k]);
    }
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA::preview_test
