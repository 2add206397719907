// Polygons, boxes and convex polyhedra: as shapes of their own, or as the triangles that they consist of.
#include <algorithm>
#include <array>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "render/scene/shape/convex.h"
#include "render/scene/shape/geometry.h"
#include "render/scene/shape/plane_polygon.h"
#include "render/scene/shape/shape_kinds.h"

namespace tessera::render {

namespace {

using Imath::V3d;

template <class Numbers>
std::vector<V3d> points_of(const Numbers& numbers) {
  std::vector<V3d> points;
  for (int i = 0; i + 2 < numbers.size(); i += 3)
    points.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
  return points;
}

template <class Numbers>
bool all_finite(const Numbers& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](float x) { return std::isfinite(x); });
}

/// A shape as both of what it may become.
struct FlatShape {
  ShapeKind kind = ShapeKind::kBox;
  Transform object_from_unit;  // the space of its record
  QuadricRecord record;
  std::vector<Facet> facets;
  wire::MeshData mesh;  // its space is that of the record
};

/// Appends a convex face, all in one plane, as a fan.
template <class Corners, class Parameters>
void append_fan(const Corners& corners, Parameters&& parameters, wire::MeshData& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size() / 3);
  for (const V3d& p : corners) {
    for (const double x : {p.x, p.y, p.z}) mesh.positions.push_back(static_cast<float>(x));
    for (const double x : parameters(p)) mesh.uvs.push_back(static_cast<float>(x));
  }
  for (std::uint32_t i = 2; i < corners.size(); ++i)
    mesh.indices.insert(mesh.indices.end(), {first, first + i - 1, first + i});
}

/// The parameters of a face of a solid in the cube from -1 to 1, as set_box_parameters() has them.
std::array<double, 2> box_parameters(const V3d& normal, const V3d& p) {
  const double size[] = {std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)};
  const int axis = size[0] >= size[1] && size[0] >= size[2] ? 0 : size[1] >= size[2] ? 1 : 2;
  const double turn = normal[axis] < 0 ? -1 : 1;
  return {(p[(axis + 1) % 3] * turn + 1) / 2, (p[(axis + 2) % 3] + 1) / 2};
}

/// The map from the cube from -1 to 1 to a box.
Transform object_from_cube(const V3d& low, const V3d& high) {
  const V3d half = (high - low) / 2, middle = (low + high) / 2;
  Transform t;
  t.m = {half.x, 0, 0, middle.x, 0, half.y, 0, middle.y, 0, 0, half.z, middle.z};
  return t;
}

absl::StatusOr<FlatShape> flat_polygon(const v1::Polygon& message) {
  if (message.corners_size() % 3 != 0 || !all_finite(message.corners()))
    return absl::InvalidArgumentError("the corners of a polygon want three finite numbers each");
  auto polygon = plane_polygon(points_of(message.corners()));
  if (!polygon.ok()) return polygon.status();
  FlatShape flat;
  flat.kind = ShapeKind::kPolygon;
  flat.object_from_unit = polygon->object_from_unit;
  std::copy(polygon->uv_map, polygon->uv_map + 6, flat.record.uv_map);
  flat.record.maps_uv = 1;
  for (const Imath::V2d& p : polygon->corners)
    flat.facets.push_back({{static_cast<float>(p.x), static_cast<float>(p.y), 0}, 0});
  return flat;
}

absl::Status triangulate_polygon(FlatShape& flat) {
  std::vector<Imath::V2d> corners;
  for (const Facet& corner : flat.facets) {
    corners.emplace_back(corner.normal[0], corner.normal[1]);
    flat.mesh.positions.insert(flat.mesh.positions.end(), {corner.normal[0], corner.normal[1], 0});
    flat.mesh.uvs.insert(flat.mesh.uvs.end(), {corner.normal[0], corner.normal[1]});
  }
  auto triangles = triangulate(corners);
  if (!triangles.ok()) return triangles.status();
  flat.mesh.indices = *std::move(triangles);
  return absl::OkStatus();
}

absl::StatusOr<FlatShape> flat_box(const v1::Box& message) {
  const std::vector<V3d> low = points_of(message.low()), high = points_of(message.high());
  if (message.low_size() != 3 || message.high_size() != 3 || !all_finite(message.low()) ||
      !all_finite(message.high()))
    return absl::InvalidArgumentError("low and high of a box want three finite numbers each");
  const V3d size = high[0] - low[0];
  if (!(std::min({size.x, size.y, size.z}) > 0))
    return absl::InvalidArgumentError("a box wants its high above its low along every axis");
  FlatShape flat;
  flat.object_from_unit = object_from_cube(low[0], high[0]);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      V3d n(0, 0, 0), a(0, 0, 0), b(0, 0, 0);
      n[axis] = side, a[(axis + 1) % 3] = side, b[(axis + 2) % 3] = 1;
      const std::array<V3d, 4> corners{n - a - b, n + a - b, n + a + b, n - a + b};
      append_fan(
          corners, [&](const V3d& p) { return box_parameters(n, p); }, flat.mesh);
    }
  }
  return flat;
}

absl::StatusOr<std::vector<Plane>> planes_of(const v1::Polyhedron& message) {
  if (message.vertices().empty() == message.planes().empty())
    return absl::InvalidArgumentError("a polyhedron wants either vertices or planes");
  if (!all_finite(message.vertices()) || !all_finite(message.planes()))
    return absl::InvalidArgumentError("a number of a polyhedron is not finite");
  constexpr int kLeast = 4, kMost = 512;
  if (!message.vertices().empty()) {
    const int count = message.vertices_size() / 3;
    if (message.vertices_size() % 3 != 0 || count < kLeast || count > kMost)
      return absl::InvalidArgumentError("a polyhedron wants 4 to 512 vertices of three numbers each");
    return hull_of(points_of(message.vertices()));
  }
  const int count = message.planes_size() / 4;
  if (message.planes_size() % 4 != 0 || count < kLeast || count > kMost)
    return absl::InvalidArgumentError("a polyhedron wants 4 to 512 planes of four numbers each");
  std::vector<Plane> planes;
  for (int i = 0; i < count; ++i) {
    const auto at = [&](int k) { return message.planes(4 * i + k); };
    planes.push_back({V3d(at(0), at(1), at(2)), at(3)});
    if (!(planes.back().normal.length() > 0))
      return absl::InvalidArgumentError("a plane of a polyhedron has no normal");
  }
  return planes;
}

absl::StatusOr<FlatShape> flat_polyhedron(const v1::Polyhedron& message) {
  const auto planes = planes_of(message);
  if (!planes.ok()) return planes.status();
  const auto faces = faces_behind(*planes);
  if (!faces.ok()) return faces.status();
  V3d low = faces->front().corners.front(), high = low;
  for (const ConvexFace& face : *faces) {
    for (const V3d& p : face.corners) {
      for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], p[a]), high[a] = std::max(high[a], p[a]);
    }
  }
  const V3d half = (high - low) / 2, middle = (low + high) / 2;
  if (!(std::min({half.x, half.y, half.z}) > 0))
    return absl::InvalidArgumentError("a polyhedron has nothing inside");
  FlatShape flat;
  flat.kind = ShapeKind::kPolyhedron;
  flat.object_from_unit = object_from_cube(low, high);
  for (const ConvexFace& face : *faces) {
    const V3d stretched = face.plane.normal * half, n = stretched.normalized();
    const double offset = (face.plane.offset - face.plane.normal.dot(middle)) / stretched.length();
    flat.facets.push_back({{static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)},
                           static_cast<float>(offset)});
    std::vector<V3d> corners = face.corners;
    for (V3d& p : corners) p = (p - middle) / half;
    append_fan(
        corners, [&](const V3d& p) { return box_parameters(n, p); }, flat.mesh);
  }
  return flat;
}

absl::StatusOr<FlatShape> flat_shape(const v1::Shape& shape) {
  if (shape.has_polygon()) return flat_polygon(shape.polygon());
  return shape.has_box() ? flat_box(shape.box()) : flat_polyhedron(shape.polyhedron());
}

/// The parameters of the mesh, mapped as the record's would be.
void map_parameters(const float (&m)[6], std::vector<float>& uvs) {
  for (std::size_t i = 0; i < uvs.size(); i += 2) {
    const float u = uvs[i], v = uvs[i + 1];
    uvs[i] = m[0] * u + m[1] * v + m[2];
    uvs[i + 1] = m[3] * u + m[4] * v + m[5];
  }
}

absl::Status add_flat_shape(const ShapeToAdd& wanted) {
  const v1::Shape& shape = wanted.shape;
  ShapeTable& table = wanted.table;
  auto flat = flat_shape(shape);
  if (!flat.ok()) return flat.status();
  const Transform placed_from_unit = wanted.placed_from_object * flat->object_from_unit;
  if (wanted.as_triangles) {
    if (flat->kind == ShapeKind::kPolygon) {
      if (auto s = triangulate_polygon(*flat); !s.ok()) return s;
    }
    if (auto s = compose_uv_map(shape, flat->record); !s.ok()) return s;
    map_parameters(flat->record.uv_map, flat->mesh.uvs);
    const wire::MeshData& mesh = flat->mesh;
    return add_mesh_arrays(shape, {mesh.positions, {}, mesh.uvs, mesh.indices}, placed_from_unit, table,
                           wanted.record);
  }
  constexpr std::size_t kMostFacets = std::size_t{1} << 28;
  if (table.facets.size() > kMostFacets)
    return absl::ResourceExhaustedError(absl::StrCat("the scene has more than ", kMostFacets, " faces"));
  wanted.record.kind = flat->kind;
  flat->record.first_facet = static_cast<std::int32_t>(table.facets.size());
  flat->record.facet_count = static_cast<std::int32_t>(flat->facets.size());
  table.facets.insert(table.facets.end(), flat->facets.begin(), flat->facets.end());
  return place_quadric(wanted, placed_from_unit, flat->record);
}

constexpr ShapeKindRow kFlatShapes[] = {
    {.message = v1::Shape::kPolygon,
     .add = &add_flat_shape,
     .why_open = [](const v1::Shape&) { return "a polygon is not closed"; }},
    {.message = v1::Shape::kBox, .add = &add_flat_shape, .box = &box_of_unit_cube},
    {.message = v1::Shape::kPolyhedron, .add = &add_flat_shape, .box = &box_of_unit_cube}};

}  // namespace

std::span<const ShapeKindRow> flat_kinds() { return kFlatShapes; }

}  // namespace tessera::render
