// Rooms of squares for tests of radiosity.
#pragma once

#include <memory>
#include <vector>

#include "render/bsdf/kinds.h"
#include "render/core/constants.h"
#include "render/light/light.h"
#include "render/textbook/radiosity/phases.h"

namespace tessera::render::TESSERA_ISA::radiosity {

/// Rays that meet nothing.
class NothingInTheWay final : public RayQuery {
 public:
  void nearest(const RayArrays&, int n, bool, const HitArrays& hits) const override {
    for (int i = 0; i < n; ++i) hits.shape[i] = -1;
  }
  void occluded(const RayArrays&, int, float*) const override {}
};

/// Rays against all triangles, one by one [Moller & Trumbore 1997].
class EveryTriangle final : public RayQuery {
 public:
  explicit EveryTriangle(const Surfaces& surfaces) {
    for (Side side = 0; side < surfaces.sides(); side += 2)
      triangles_.push_back(surfaces.patch(Name::of_side(side)));
  }
  void nearest(const RayArrays&, int n, bool, const HitArrays& hits) const override {
    for (int i = 0; i < n; ++i) hits.shape[i] = -1;
  }
  void occluded(const RayArrays& rays, int n, float* distance) const override {
    for (int i = 0; i < n; ++i) {
      const Vec o{rays.ox[i], rays.oy[i], rays.oz[i]}, d{rays.dx[i], rays.dy[i], rays.dz[i]};
      for (const Patch& triangle : triangles_) {
        const Vec e1 = triangle.corner[1] - triangle.corner[0], e2 = triangle.corner[2] - triangle.corner[0];
        const Vec p = cross(d, e2), s = o - triangle.corner[0], q = cross(s, e1);
        const double determinant = dot(e1, p);
        if (determinant == 0) continue;
        const double u = dot(s, p) / determinant, v = dot(d, q) / determinant, t = dot(e2, q) / determinant;
        if (u >= 0 && v >= 0 && u + v <= 1 && t >= 0 && t <= double{distance[i]}) distance[i] = -1;
      }
    }
  }

 private:
  std::vector<Patch> triangles_;
};

/// A parallelogram of two triangles, seen from where cross(a, b) points to.
struct Square {
  Vec corner, a, b;
  float reflectance = 0, exitance = 0;
  int painted_as = -1;  // the material that it shares; -1: one of its own, numbered as they come
};

/// A lamp that has no surface.
struct PointLamp {
  Vec place;
  float intensity = 0;  // W/sr
};

/// Solves for light until a sweep moves no more than `residual`.
inline Forest::Outcome solve(Forest& forest, double residual) {
  while (!forest.advance(residual)) {
  }
  return forest.outcome();
}

/// Squares as a scene: square i has sides 4 i and 4 i + 2 to the front, 4 i + 1 and 4 i + 3 to the back.
class Room {
 public:
  /// `sees_through`: nothing is in the way of anything.
  explicit Room(const std::vector<Square>& squares, bool sees_through = true,
                const std::vector<PointLamp>& lamps = {}) {
    for (const Square& square : squares) add(square);
    for (const PointLamp& lamp : lamps) {
      LightRecord& light = arrays_.lights.lights.emplace_back();
      for (float& value : light.radiance) value = lamp.intensity;
      for (std::size_t i = 0; i < 3; ++i) light.position[i] = static_cast<float>(lamp.place[i]);
    }
    arrays_.shapes.world_shape_count = static_cast<std::int32_t>(arrays_.shapes.shapes.size());
    arrays_.lights.sources = light_sources();
    arrays_.lights.shapes = &arrays_.shapes;
    arrays_.lights.textures = &arrays_.textures;
    surfaces_ = std::make_unique<Surfaces>(arrays_.shapes);
    clusters_ = std::make_unique<Clusters>(*surfaces_);
    if (sees_through) {
      rays_ = std::make_unique<NothingInTheWay>();
    } else {
      rays_ = std::make_unique<EveryTriangle>(*surfaces_);
    }
  }

  const SceneTables& scene() const { return scene_; }
  const ShapeTable& shapes() const { return arrays_.shapes; }
  const Surfaces& surfaces() const { return *surfaces_; }
  const Clusters& clusters() const { return *clusters_; }

  /// All links, with sources of these brightnesses.
  Links link(const std::vector<Brightness::Value>& sides, const LinkBounds& bounds) const {
    Brightness brightness{sides, {}};
    pull(*surfaces_, *clusters_, brightness);
    RenderStats stats;
    const IntegratorContext context{scene_, *rays_, 0, stats};
    const auto linker = std::make_unique<Linker>(context, *surfaces_, *clusters_, brightness, bounds);
    Links links;
    for (Side side = 0; side < surfaces_->sides(); ++side) linker->link(side, links);
    return links;
  }
  Forest grow(const Links& links) const { return *Forest::grow(scene_, *surfaces_, *clusters_, links); }
  bool grows(const Links& links, int deepest = Name::kDeepest) const {
    return Forest::grow(scene_, *surfaces_, *clusters_, links, deepest).has_value();
  }
  void set_memory_limit(std::uint64_t bytes) { scene_.radiosity.memory_limit = bytes; }

 private:
  void add(const Square& square) {
    ShapeRecord shape;
    shape.material = square.painted_as;
    shape.first_triangle = static_cast<std::int32_t>(arrays_.shapes.triangles.size() / 3);
    shape.first_vertex = static_cast<std::int32_t>(arrays_.shapes.vertices.size());
    shape.triangle_count = 2;
    shape.vertex_count = 4;
    for (const Vec& p : {square.corner, square.corner + square.a, square.corner + square.a + square.b,
                         square.corner + square.b}) {
      render::Vertex vertex;
      for (std::size_t i = 0; i < 3; ++i) vertex.position[i] = static_cast<float>(p[i]);
      arrays_.shapes.vertices.push_back(vertex);
    }
    for (const std::uint32_t corner : {0u, 1u, 2u, 0u, 2u, 3u}) arrays_.shapes.triangles.push_back(corner);
    if (shape.material < 0) {
      shape.material = static_cast<std::int32_t>(arrays_.materials.materials.size());
      MaterialRecord& material = arrays_.materials.materials.emplace_back();
      for (float& value : material.spectra[slot::kReflectance].value) value = square.reflectance;
    }
    if (square.exitance > 0) shape.first_light = static_cast<std::int32_t>(arrays_.lights.lights.size());
    arrays_.shapes.shapes.push_back(shape);
    if (square.exitance <= 0) return;
    for (std::int32_t primitive = 0; primitive < 2; ++primitive) {
      LightRecord light;
      light.kind = LightKind::kTriangle;
      light.shape = static_cast<std::int32_t>(arrays_.shapes.shapes.size()) - 1;
      light.primitive = primitive;
      for (float& value : light.radiance) value = square.exitance / kPi;
      arrays_.lights.lights.push_back(light);
    }
  }

  SceneArrays arrays_;
  SceneTables scene_{arrays_};
  std::unique_ptr<Surfaces> surfaces_;
  std::unique_ptr<Clusters> clusters_;
  std::unique_ptr<RayQuery> rays_;
};

/// The inside of a unit cube; the floor first, then the ceiling.
inline std::vector<Square> cube(float reflectance, float exitance) {
  std::vector<Square> walls = {{{0, 0, 0}, {0, 0, 1}, {1, 0, 0}}, {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},
                               {{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
                               {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}}};
  for (Square& wall : walls) wall.reflectance = reflectance, wall.exitance = exitance;
  return walls;
}

}  // namespace tessera::render::TESSERA_ISA::radiosity
