// Scenes of triangles, and what a preview and rays make of them.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "render/sensor/sensor.h"
#include "render/textbook/preview/frame.h"
#include "render/textbook/preview/preview.h"
#include "render/textbook/preview/raster.h"
#include "support/kernel/kernel_scene.h"

namespace tessera::render::TESSERA_ISA::preview_test {

using Place = std::array<float, 3>;

/// Appends a mesh to the world, of the scene's first material.
inline void add_mesh(SceneArrays& arrays, const std::vector<Place>& places,
                     const std::vector<std::uint32_t>& triangles) {
  ShapeTable& table = arrays.shapes;
  ShapeRecord shape;
  shape.first_triangle = static_cast<std::int32_t>(table.triangles.size() / 3);
  shape.first_vertex = static_cast<std::int32_t>(table.vertices.size());
  shape.triangle_count = static_cast<std::int32_t>(triangles.size() / 3);
  shape.vertex_count = static_cast<std::int32_t>(places.size());
  for (const Place& p : places) table.vertices.push_back({.position = {p[0], p[1], p[2]}});
  table.triangles.insert(table.triangles.end(), triangles.begin(), triangles.end());
  table.shapes.insert(table.shapes.begin() + table.world_shape_count, shape);
  ++table.world_shape_count;
  for (ObjectRange& object : table.objects) ++object.first_shape;
}

/// A rectangle: a corner and two sides.
inline void add_rectangle(SceneArrays& arrays, Place at, Place u, Place v) {
  const auto corner = [&](float a, float b) {
    return Place{at[0] + a * u[0] + b * v[0], at[1] + a * u[1] + b * v[1], at[2] + a * u[2] + b * v[2]};
  };
  add_mesh(arrays, {corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)}, {0, 1, 2, 0, 2, 3});
}

/// A camera at (0, 0, -4) that looks along z, grey paint, and `more`; render space is world space.
inline std::string scene_text(const std::string& more = "", double fov = 60) {
  return absl::StrCat("render_origin {} camera { perspective { fov_degrees: ", fov,
                      " } world_from_camera { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-4, 0,0,0,1] } }"
                      " film { width: 64 height: 64 filter { kind: BOX radius_x: 1e-6 radius_y: 1e-6 } }"
                      " materials { name: 'paint' diffuse { reflectance { constant { constant: 0.5 } } } } ",
                      more);
}

/// Shapes and primitives seen through the middles of all pixels.
struct Items {
  std::vector<std::int32_t> shape, primitive, instance;
  std::vector<float> t;  // rays only; the frame has none
};

inline Items items_by_raster(const SceneTables& tables, const RayQuery& rays) {
  const PreviewFrame frame(tables);
  EXPECT_TRUE(frame.finish(rays, {}));
  const auto raster = std::make_unique<Raster>(tables, frame.clusters(), rays);
  const View view = frame.view(kSubPixels / 2, kSubPixels / 2);
  const int width = tables.sensor.width, height = tables.sensor.height;
  Items items;
  const auto size = static_cast<std::size_t>(width * height);
  items.shape.resize(size), items.primitive.resize(size), items.instance.resize(size);
  const auto hits = std::make_unique<BinHits>();
  for (int row = 0; row < view.bins.rows(); ++row) {
    for (int column = 0; column < view.bins.columns(); ++column) {
      raster->render(view, column, row);
      raster->resolve(*hits);
      for (int i = 0; i < kBinPixels; ++i) {
        const int x = column * kBinSide + i % kBinSide, y = row * kBinSide + i / kBinSide;
        if (x >= width || y >= height) continue;
        const auto to = static_cast<std::size_t>(y * width + x);
        items.shape[to] = hits->shape[i];
        items.primitive[to] = hits->primitive[i];
        items.instance[to] = hits->instance[i];
      }
    }
  }
  return items;
}

/// The same by rays through the pixels' middles, or (`dx`, `dy`) pixels off them.
inline Items items_by_rays(const SceneTables& tables, const RayQuery& rays, float dx = 0, float dy = 0) {
  Items items;
  const auto batch = std::make_unique<std::tuple<Vec3Lanes, Vec3Lanes, HitState>>();
  auto& [origin, direction, hits] = *batch;
  const int width = tables.sensor.width, pixels = width * tables.sensor.height;
  for (int first = 0; first < pixels; first += kBatch) {
    const int count = std::min(kBatch, pixels - first);
    for (int i = 0; i < count; i += kWidth) {
      alignas(64) float x[kWidth], y[kWidth];
      for (int k = 0; k < kWidth; ++k) {
        x[k] = static_cast<float>((first + i + k) % width) + 0.5f + dx;
        y[k] = static_cast<float>((first + i + k) / width) + 0.5f + dy;
      }
      const SensorRay ray = start_ray(
          tables.sensor, {{Float::load(x), Float::load(y)}, {Float(0.5f), Float(0.5f)}, Float(0.0f)});
      store_lanes(ray.origin, origin, i);
      store_lanes(ray.direction, direction, i);
    }
    rays.nearest(arrays_of(origin, direction, nullptr), count, true, hits.arrays());
    for (int i = 0; i < count; ++i) {
      items.shape.push_back(hits.shape[i]);
      items.primitive.push_back(hits.shape[i] < 0 ? 0 : hits.primitive[i]);
      items.instance.push_back(hits.shape[i] < 0 ? -1 : hits.instance[i]);
      items.t.push_back(hits.t[i]);
    }
  }
  return items;
}

/// A picture by the preview with samples at the pixels' middles.
inline wire::TileResult preview_picture(const SceneContent& content, const SceneTables& tables,
                                        const std::vector<v1::AOV>& aovs = {}, std::uint32_t samples = 1) {
  wire::TileResult result = empty_picture(content.tables, samples);
  result.channels = wire::channels_for_aovs(aovs);
  RenderStats stats;
  FixedTile film(result);
  const auto prepared = Preview::prepare(tables, {});
  Preview preview(
      IntegratorContext{tables, *content.rays, content.tables.sampler.seed, stats, prepared.get()});
  EXPECT_TRUE(preview.render(film, film, {}));
  EXPECT_EQ(stats.dropped_samples, 0u);
  return result;
}

}  // namespace tessera::render::TESSERA_ISA::preview_test
