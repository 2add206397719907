#include "render/accel/intersection_probe.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "render/shape/shape_table.h"

namespace tessera::render {

namespace {

using Vec = std::array<double, 3>;

Vec difference(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double length(const Vec& a) { return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }
double largest(const Vec& a) { return std::max({std::abs(a[0]), std::abs(a[1]), std::abs(a[2])}); }

/// A shape where it stands, or where one instance puts it.
struct PlacedShape {
  std::int32_t shape;
  Vec eye;  // the camera, in the space that the shape's vertices are in
};

/// Shapes that only objects in objects place: each where the first way down leads, for there may be more
/// places than can be counted. Objects come after those that they hold.
void add_inner_shapes(const ShapeTable& table, std::vector<PlacedShape>& placed) {
  std::vector<std::optional<Vec>> eyes(table.objects.size());
  const auto look = [&](const InstanceRecord& instance, const Vec& eye) {
    const auto& m = instance.instance_from_render.m;
    std::optional<Vec>& own = eyes[static_cast<std::size_t>(instance.object)];
    if (own) return;
    own.emplace();
    for (std::size_t k = 0; k < 3; ++k)
      (*own)[k] = m[4 * k] * eye[0] + m[4 * k + 1] * eye[1] + m[4 * k + 2] * eye[2] + m[4 * k + 3];
  };
  for (const InstanceRecord& instance : table.instances) look(instance, {0, 0, 0});
  for (std::size_t i = table.objects.size(); i-- > 0;) {
    if (!eyes[i]) continue;
    for (const InstanceRecord& inner : table.inner_of(table.objects[i])) {
      const ObjectRange& object = table.objects[static_cast<std::size_t>(inner.object)];
      const bool known = eyes[static_cast<std::size_t>(inner.object)].has_value();
      look(inner, *eyes[i]);
      for (std::int32_t s = 0; !known && s < object.shape_count; ++s)
        placed.push_back({object.first_shape + s, *eyes[static_cast<std::size_t>(inner.object)]});
    }
  }
}

std::vector<PlacedShape> placed_shapes(const ShapeTable& table) {
  std::vector<PlacedShape> placed;
  for (std::int32_t i = 0; i < table.world_shape_count; ++i) placed.push_back({i, {0, 0, 0}});
  for (const InstanceRecord& instance : table.instances) {
    const auto& m = instance.instance_from_render.m;
    const ObjectRange& object = table.objects[static_cast<std::size_t>(instance.object)];
    for (std::int32_t i = 0; i < object.shape_count; ++i)
      placed.push_back({object.first_shape + i, {m[3], m[7], m[11]}});
  }
  if (table.nested()) add_inner_shapes(table, placed);
  std::erase_if(placed, [&](const PlacedShape& p) {
    return table.shapes[static_cast<std::size_t>(p.shape)].kind != ShapeKind::kTriangles;
  });
  return placed;
}

/// Sums over triangles, by solid angle.
struct Sums {
  double seen = 0, leaking = 0, too_fine = 0;

  Sums& operator+=(const Sums& other) {
    seen += other.seen, leaking += other.leaking, too_fine += other.too_fine;
    return *this;
  }
  double leak() const { return seen > 0 ? leaking / seen : 0; }
};

Sums look_at(const ShapeTable& table, const ShapeRecord& shape, std::int32_t triangle, const Vec& eye) {
  Vec p[3];
  const std::uint32_t* corner =
      &table.triangles[3 * static_cast<std::size_t>(shape.first_triangle + triangle)];
  for (std::size_t i = 0; i < 3; ++i) {
    const float* v = table.vertices[static_cast<std::size_t>(shape.first_vertex) + corner[i]].position;
    p[i] = {v[0], v[1], v[2]};
  }
  const Vec a = difference(p[1], p[0]), b = difference(p[2], p[0]), c = difference(p[2], p[1]);
  const double twice_area = length(cross(a, b)), longest = std::max({length(a), length(b), length(c)});
  if (!(twice_area > 0)) return {};
  const double height = twice_area / longest;
  Vec middle;
  for (std::size_t i = 0; i < 3; ++i) middle[i] = (p[0][i] + p[1][i] + p[2][i]) / 3;
  const double distance = std::max(length(difference(middle, eye)), longest / 2);
  const double coordinates = std::max({largest(p[0]), largest(p[1]), largest(p[2]), largest(eye)});

  // Measured on closed meshes (docs/numerics.md): the edges' own errors are a strip as wide as roundings of
  // the distance; those of the boxes' sides are as large as roundings of the coordinates, and what slips
  // between two of them goes by the square.
  constexpr double kEdges = 1e-8, kBoxes = 0.07;
  const double missed = 0x1p-24 * coordinates / height;
  const double leak = std::min(1.0, kEdges * distance / height + kBoxes * missed * missed);
  const double angle = std::min(twice_area / 2 / (distance * distance), 2 * std::numbers::pi);
  const bool fine = height < IntersectionProbe::kFinest * std::max(distance, coordinates);
  return {angle, leak * angle, fine ? angle : 0};
}

/// Sums over `count` triangles spread over the shape, scaled to all of them.
Sums look_at_some(const ShapeTable& table, const PlacedShape& placed, std::int64_t count) {
  const ShapeRecord& shape = table.shapes[static_cast<std::size_t>(placed.shape)];
  Sums sums;
  for (std::int64_t k = 0; k < count; ++k) {
    // Steps of the golden ratio: evenly spread, and in step with no mesh's own order.
    const double at = std::fmod((static_cast<double>(k) + 0.5) * std::numbers::phi, 1.0);
    const auto triangle = count == shape.triangle_count
                              ? static_cast<std::int32_t>(k)
                              : static_cast<std::int32_t>(at * shape.triangle_count);
    sums += look_at(table, shape, triangle, placed.eye);
  }
  const double each =
      static_cast<double>(shape.triangle_count) / static_cast<double>(std::max<std::int64_t>(count, 1));
  sums.seen *= each, sums.leaking *= each, sums.too_fine *= each;
  return sums;
}

}  // namespace

IntersectionProbe probe_intersection(const ShapeTable& table) {
  constexpr std::size_t kMostShapes = 1 << 14;
  constexpr std::int64_t kMostTriangles = 1 << 16;
  const std::vector<PlacedShape> placed = placed_shapes(table);
  const std::size_t step = std::max<std::size_t>(1, placed.size() / kMostShapes);
  std::int64_t looked_at = 0, triangles = 0;
  for (std::size_t i = 0; i < placed.size(); i += step) {
    triangles += table.shapes[static_cast<std::size_t>(placed[i].shape)].triangle_count;
    ++looked_at;
  }
  IntersectionProbe probe;
  Sums all;
  double most_fine = 0;
  for (std::size_t i = 0; i < placed.size(); i += step) {
    const ShapeRecord& shape = table.shapes[static_cast<std::size_t>(placed[i].shape)];
    const std::int64_t own =
        std::max<std::int64_t>(kMostTriangles / 2 / looked_at, shape.triangle_count * (kMostTriangles / 2) /
                                                                   std::max<std::int64_t>(triangles, 1));
    const Sums sums = look_at_some(table, placed[i], std::min<std::int64_t>(own, shape.triangle_count));
    all += sums;
    if (sums.leak() > probe.shape_leak) probe.shape_leak = sums.leak(), probe.leaking_shape = placed[i].shape;
    if ((shape.flags & kMediumBorder) && sums.leak() > probe.border_leak) {
      probe.border_leak = sums.leak(), probe.leaking_border = placed[i].shape;
    }
    if (sums.too_fine > most_fine) most_fine = sums.too_fine, probe.finest_shape = placed[i].shape;
  }
  probe.leak = all.leak();
  probe.too_fine = all.seen > 0 ? all.too_fine / all.seen : 0;
  return probe;
}

}  // namespace tessera::render
