// Tables of shapes that are hard on structures: what overlaps, what is flat, what is not there, what is far
// apart in size.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "render/shape/place.h"
#include "render/shape/shape_table.h"
#include "stress/geometry/closed_mesh.h"
#include "stress/geometry/traced_table.h"

namespace tessera::render::TESSERA_ISA {

/// Puts shapes together. All of them stand in the world, unless `begin_objects` was called.
class TableMaker {
 public:
  /// Triangles of the mesh that is being made.
  void add(Point a, Point b, Point c) {
    for (const Point& p : {a, b, c}) {
      triangles_.push_back(static_cast<std::uint32_t>(vertices_.size()));
      vertices_.push_back({{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)}});
    }
  }
  void end_mesh() {
    ShapeRecord& shape = add_shape(ShapeKind::kTriangles);
    shape.first_triangle = static_cast<std::int32_t>(table_.triangles.size() / 3);
    shape.first_vertex = static_cast<std::int32_t>(table_.vertices.size());
    shape.triangle_count = static_cast<std::int32_t>(triangles_.size() / 3);
    shape.vertex_count = static_cast<std::int32_t>(vertices_.size());
    table_.triangles.insert(table_.triangles.end(), triangles_.begin(), triangles_.end());
    table_.vertices.insert(table_.vertices.end(), vertices_.begin(), vertices_.end());
    triangles_.clear(), vertices_.clear();
  }
  void add_mesh(const ClosedMesh& mesh, Point centre, double radius) {
    const auto at = [&](std::uint32_t i) {
      const auto& p = mesh.vertices[i];
      return centre + Point{p[0], p[1], p[2]} * radius;
    };
    for (const auto& [a, b, c] : mesh.triangles) add(at(a), at(b), at(c));
  }
  void add_quadric(ShapeKind kind, Point centre, double radius, double z_max) {
    add_shape(kind).quadric = static_cast<std::int32_t>(table_.quadrics.size());
    QuadricRecord& q = table_.quadrics.emplace_back();
    q.radius = static_cast<float>(radius);
    q.z_min = static_cast<float>(-radius), q.z_max = static_cast<float>(z_max);
    q.partial = z_max < radius;
    const double c[3] = {centre.x, centre.y, centre.z};
    for (int k = 0; k < 3; ++k) {
      q.render_from_object.m[4 * k + 3] = static_cast<float>(c[k]);
      q.object_from_render.m[4 * k + 3] = -static_cast<float>(c[k]);
    }
  }
  /// Ends the world's shapes; then the objects' follow, which `end_object` ends one by one.
  void begin_objects() {
    objects_ = true;
    first_of_object_ = static_cast<std::int32_t>(table_.shapes.size());
  }
  void end_object() {
    const auto n = static_cast<std::int32_t>(table_.shapes.size());
    const auto inner = static_cast<std::int32_t>(table_.inner.size());
    table_.objects.push_back({first_of_object_, n - first_of_object_, first_inner_, inner - first_inner_});
    first_of_object_ = n, first_inner_ = inner;
  }
  /// With two steps or more it moves.
  void add_instance(std::int32_t object, const std::vector<Affine>& steps) {
    place(object, steps, table_.instances.emplace_back());
  }
  /// Into the object that is being made.
  void add_inner(std::int32_t object, const std::vector<Affine>& steps) {
    place(object, steps, table_.inner.emplace_back());
  }
  ShapeTable take() {
    if (table_.nested()) number_places(table_);
    return std::move(table_);
  }

 private:
  void place(std::int32_t object, const std::vector<Affine>& steps, InstanceRecord& instance) {
    instance.object = object;
    instance.render_from_instance = steps.front();
    const ExactAffine back = inverse(exact(steps.front()));
    for (int i = 0; i < 12; ++i) instance.instance_from_render.m[i] = static_cast<float>(back.m[i]);
    if (steps.size() == 1) return;
    instance.first_step = static_cast<std::int32_t>(table_.motion_steps.size());
    instance.segments = static_cast<std::int32_t>(steps.size()) - 1;
    table_.motion_steps.insert(table_.motion_steps.end(), steps.begin(), steps.end());
  }
  ShapeRecord& add_shape(ShapeKind kind) {
    ShapeRecord& shape = table_.shapes.emplace_back();
    shape.kind = kind;
    if (!objects_) ++table_.world_shape_count;
    return shape;
  }

  ShapeTable table_;
  std::vector<std::uint32_t> triangles_;
  std::vector<Vertex> vertices_;
  bool objects_ = false;
  std::int32_t first_of_object_ = 0, first_inner_ = 0;
};

inline Affine placing(Point at, double turn, std::array<double, 3> scale) {
  const double c = std::cos(turn), s = std::sin(turn);
  const double m[12] = {c * scale[0], -s * scale[1], 0, at.x, s * scale[0], c * scale[1], 0, at.y, 0, 0,
                        scale[2],     at.z};
  Affine a;
  for (int i = 0; i < 12; ++i) a.m[i] = static_cast<float>(m[i]);
  return a;
}

inline Point in_cube(Numbers& random, double side) {
  return {side * (random() - 0.5), side * (random() - 0.5), side * (random() - 0.5)};
}

/// Long and thin, in all directions, all through one another.
inline ShapeTable slivers(std::int64_t n) {
  TableMaker maker;
  Numbers random(11);
  for (std::int64_t i = 0; i < n; ++i) {
    const Point a = in_cube(random, 2), b = a + random.direction() * random();
    maker.add(a, b, a + (b - a) * random() + random.direction() * 1e-4);
  }
  maker.end_mesh();
  return maker.take();
}

/// Sheets of one plane across each axis, and askew, each several times; twins; what has no area, and what is
/// not finite.
inline ShapeTable sheets() {
  TableMaker maker;
  Numbers random(12);
  const Point frames[4][2] = {
      {{1, 0, 0}, {0, 1, 0}}, {{0, 1, 0}, {0, 0, 1}}, {{0, 0, 1}, {1, 0, 0}}, {{1, 1, 0}, {0, 1, 1}}};
  for (const auto& [x, y] : frames) {
    for (int copy = 0; copy < 3; ++copy) {
      for (int i = -4; i < 4; ++i) {
        for (int j = -4; j < 4; ++j) {
          const auto at = [&](double s, double t) { return x * (0.25 * s) + y * (0.25 * t); };
          maker.add(at(i, j), at(i + 1, j), at(i + 1, j + 1));
          maker.add(at(i, j), at(i + 1, j + 1), at(i, j + 1));
        }
      }
      if (copy > 0) maker.end_mesh();
    }
  }
  for (int i = 0; i < 300; ++i) maker.add({0.1, 0.2, -0.7}, {0.9, 0.1, 0.3}, {0.2, 0.8, 0.5});
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = HUGE_VAL;
  for (int i = 0; i < 200; ++i) {
    const Point a = in_cube(random, 2), b = in_cube(random, 2);
    maker.add(a, a, a);
    maker.add(a, b, b);
    maker.add(a, a + (b - a) * 0.5, b);
    maker.add({nan, a.y, a.z}, b, a + b);
    maker.add(a, {inf, 0, 0}, b);
    maker.add(a, b, {0, -3e38, 0});
  }
  maker.end_mesh();
  return maker.take();
}

/// A fine mesh in the middle of a few large triangles [Haines's teapot in a stadium].
inline ShapeTable stadium() {
  TableMaker maker;
  for (int i = 0; i < 12; ++i) {
    const double a = i * M_PI / 6, b = (i + 1) * M_PI / 6, r = 2000;
    const Point p{r * std::cos(a), r * std::sin(a), -1}, q{r * std::cos(b), r * std::sin(b), -1};
    maker.add({0, 0, -1}, p, q);
    maker.add(p, q, q + Point{0, 0, 300});
    maker.add(p, q + Point{0, 0, 300}, p + Point{0, 0, 300});
  }
  maker.end_mesh();
  maker.add_mesh(displaced_sphere(4), {0.3, -0.2, 0.1}, 0.8);
  maker.end_mesh();
  return maker.take();
}

/// Quadrics among triangles, objects turned, mirrored, squashed, without extent, moving, and one in another.
inline ShapeTable many_kinds() {
  TableMaker maker;
  Numbers random(13);
  for (int i = 0; i < 40; ++i) {
    const ShapeKind kind = i % 3 == 0   ? ShapeKind::kSphere
                           : i % 3 == 1 ? ShapeKind::kDisk
                                        : ShapeKind::kCylinder;
    const double radius = 0.02 + 0.2 * random();
    maker.add_quadric(kind, in_cube(random, 3), radius, i % 4 == 0 ? 0.3 * radius : radius);
  }
  maker.add_mesh(displaced_sphere(2), {0, 0, 0}, 0.5);
  maker.end_mesh();
  maker.begin_objects();
  maker.add_mesh(displaced_sphere(2), {0, 0, 0}, 1);
  maker.end_mesh();
  maker.add_quadric(ShapeKind::kSphere, {0, 0, 1.2}, 0.5, 0.5);
  maker.end_object();
  maker.add_quadric(ShapeKind::kSphere, {0, 0, 0}, 1, 1);
  maker.end_object();
  for (int i = 0; i < 60; ++i) {
    const double s = 0.05 + 0.15 * random();
    maker.add_instance(i % 2, {placing(in_cube(random, 3), 6 * random(), {i % 3 == 0 ? -s : s, s, 0.4 * s})});
  }
  const Affine same = placing({0.2, 0.3, 0.4}, 1, {0.3, 0.3, 0.3});
  for (int i = 0; i < 3; ++i) maker.add_instance(0, {same});
  maker.add_instance(0, {placing({0, 0, 0}, 0, {0, 0, 0})});
  for (int i = 0; i < 10; ++i) {
    const Point from = in_cube(random, 3), way = in_cube(random, 1);
    std::vector<Affine> steps;
    for (int k = 0; k <= i % 3 + 1; ++k)
      steps.push_back(placing(from + way * k, 0.5 * k, {0.1 + 0.05 * k, 0.1, 0.1}));
    maker.add_instance(i % 2, steps);
  }
  return maker.take();
}

/// Objects five deep, which hold shapes and one another, mirrored, squashed, without extent, alike, moving.
inline ShapeTable nested_kinds() {
  TableMaker maker;
  Numbers random(14);
  maker.add_mesh(displaced_sphere(2), {0, 0, 0}, 0.4);
  maker.end_mesh();
  maker.begin_objects();
  maker.add_mesh(displaced_sphere(1), {0, 0, 0}, 1);
  maker.end_mesh();
  maker.end_object();
  for (std::int32_t level = 1; level < 5; ++level) {
    if (level % 2 == 0) maker.add_quadric(ShapeKind::kSphere, {0, 0, 0}, 0.5, 0.2);
    for (int i = 0; i < 3; ++i) {
      const double s = 0.3 + 0.2 * random();
      std::vector<Affine> steps;
      for (int k = 0; k <= (i == 1 ? level % 3 : 0); ++k)
        steps.push_back(placing(in_cube(random, 2), 6 * random(), {i == 0 ? -s : s, s, 0.6 * s}));
      maker.add_inner(i == 2 ? 0 : level - 1, steps);
    }
    const Affine same = placing({0.2, 0.3, 0.4}, 1, {0.3, 0.3, 0.3});
    for (int twin = 0; twin < 2 && level == 2; ++twin) maker.add_inner(1, {same});
    if (level == 3) maker.add_inner(2, {placing({0, 0, 0}, 0, {0, 0, 0})});
    maker.end_object();
  }
  for (int i = 0; i < 8; ++i)
    maker.add_instance(4 - i % 3,
                       {placing(in_cube(random, 3), 6 * random(), {i % 3 == 0 ? -0.6 : 0.6, 0.5, 0.4})});
  return maker.take();
}

/// The same, larger or smaller and elsewhere.
inline ShapeTable scaled(ShapeTable table, double scale, Point to) {
  const double shift[3] = {to.x, to.y, to.z};
  for (Vertex& v : table.vertices) {
    for (int k = 0; k < 3; ++k) v.position[k] = static_cast<float>(scale * v.position[k] + shift[k]);
  }
  return table;
}

}  // namespace tessera::render::TESSERA_ISA
