#include <algorithm>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "render/build/scene_builder.h"

namespace tessera::render {

namespace {

bool finite(float x) { return std::isfinite(x); }

/// The vertices of `mesh`, placed by `placed_from_object`, appended. False when one is not finite.
bool append_vertices(const wire::MeshView& mesh, const Transform& placed_from_object, BigArray<Vertex>& out) {
  bool sound = true;
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    const float* xyz = mesh.positions.data() + 3 * i;
    const Point p = placed_from_object.apply({xyz[0], xyz[1], xyz[2]});
    Vertex& v = out.emplace_back();
    v.position[0] = static_cast<float>(p.x), v.position[1] = static_cast<float>(p.y),
    v.position[2] = static_cast<float>(p.z);
    for (const float x : v.position) sound = sound && finite(x);
    if (!mesh.uvs.empty()) v.u = mesh.uvs[2 * i], v.v = mesh.uvs[2 * i + 1];
  }
  return sound;
}

/// Shading normals through the inverse transpose, turned over when asked.
void set_normals(const wire::MeshView& mesh, const Transform& object_from_placed, bool turn,
                 Vertex* vertices) {
  const auto& m = object_from_placed.m;
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    const double x = mesh.normals[3 * i], y = mesh.normals[3 * i + 1], z = mesh.normals[3 * i + 2];
    const Point n{m[0] * x + m[4] * y + m[8] * z, m[1] * x + m[5] * y + m[9] * z,
                  m[2] * x + m[6] * y + m[10] * z};
    const double l = length(n);
    const double scale = l > 0 && std::isfinite(l) ? (turn ? -1 : 1) / l : 0;
    vertices[i].normal[0] = static_cast<float>(n.x * scale);
    vertices[i].normal[1] = static_cast<float>(n.y * scale);
    vertices[i].normal[2] = static_cast<float>(n.z * scale);
  }
}

Point point(const float (&xyz)[3]) { return {xyz[0], xyz[1], xyz[2]}; }

/// Winds triangles so that cross(p1 - p0, p2 - p0) is the geometric normal: on the side of the shading
/// normals where there are any [pbrt-v4 Triangle::Intersect], else as the mesh has it, turned over when
/// asked.
void append_triangles(const wire::MeshView& mesh, const Vertex* vertices, bool with_normals, bool turn,
                      BigArray<std::uint32_t>& out) {
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const std::uint32_t a = mesh.indices[i], b = mesh.indices[i + 1], c = mesh.indices[i + 2];
    bool swap = turn;
    if (with_normals) {
      const Point p = point(vertices[a].position);
      const Point n = cross(point(vertices[b].position) - p, point(vertices[c].position) - p);
      const double side = dot(n, point(vertices[a].normal)) + dot(n, point(vertices[b].normal)) +
                          dot(n, point(vertices[c].normal));
      if (side != 0) swap = side < 0;
    }
    out.insert(out.end(), {a, swap ? c : b, swap ? b : c});
  }
}

}  // namespace

std::string place_in_scene(const char* what, int index, const std::string& name) {
  return name.empty() ? absl::StrCat(what, " ", index) : absl::StrCat(what, " ", index, " (", name, ")");
}

absl::Status SceneBuilder::build_shapes() {
  std::vector<int> moving;
  for (int i = 0; i < scene_.shapes_size(); ++i) {
    const v1::Shape& shape = scene_.shapes(i);
    const std::string where = place_in_scene("shape", i, shape.name());
    const auto moves_too = moves(shape, false, where);
    if (!moves_too.ok()) return located(moves_too.status(), where);
    if (*moves_too) {
      moving.push_back(i);
      continue;
    }
    const auto world_from_object = Transform::from_proto(shape.world_from_object());
    if (!world_from_object.ok()) return located(world_from_object.status(), where);
    if (auto s = build_shape(shape, render_from_world_ * *world_from_object, false, where); !s.ok())
      return located(s, where);
  }
  arrays_.shapes.world_shape_count = static_cast<std::int32_t>(arrays_.shapes.shapes.size());
  if (auto s = build_objects(); !s.ok()) return s;
  if (auto s = build_moving_shapes(moving); !s.ok()) return s;
  return build_instances();
}

absl::Status SceneBuilder::build_shape(const v1::Shape& shape, const Transform& placed_from_object,
                                       bool instanced, const std::string& where) {
  ShapeRecord record;
  const auto material = material_index(shape.material());
  if (!material.ok()) return material.status();
  record.material = *material;
  const bool interface = arrays_.materials.materials[*material].kind == BsdfKind::kInterface;
  if (auto s = set_media(shape, record); !s.ok()) return s;
  // A surface of nothing matters only as the border of a medium.
  if (interface && !shape.has_area_light() && !(record.flags & kMediumBorder)) return absl::OkStatus();

  if (auto s = set_alpha(shape, record); !s.ok()) return s;
  switch (shape.kind_case()) {
    case v1::Shape::kMesh:
      if (auto s = add_mesh(shape, placed_from_object, record); !s.ok()) return s;
      break;
    case v1::Shape::kSphere:
    case v1::Shape::kDisk:
    case v1::Shape::kCylinder:
      if (record.flags & kHasAlpha)
        warnings_.push_back(absl::StrCat(where, ": alpha is for meshes only; left out"));
      if (auto s = add_quadric(shape, placed_from_object, record); !s.ok()) return s;
      break;
    case v1::Shape::kSdfGrid:
      if (auto s = add_sdf_grid(shape, placed_from_object, record); !s.ok()) return s;
      break;
    case v1::Shape::kCurves:
      if (auto s = add_curves(shape, placed_from_object, record); !s.ok()) return s;
      break;
    case v1::Shape::KIND_NOT_SET:
      return absl::InvalidArgumentError("its kind is missing or unknown");
  }
  const auto shape_index = static_cast<std::int32_t>(arrays_.shapes.shapes.size());
  arrays_.shapes.shapes.push_back(record);
  shape_names_.push_back(where);
  if (shape.has_mesh()) {
    if (auto s = add_attributes(shape.mesh(), shape_index); !s.ok()) return s;
  }
  if (!shape.has_area_light()) return absl::OkStatus();
  if (shape.has_sdf_grid()) return absl::InvalidArgumentError("a grid of distances cannot emit light");
  if (shape.has_curves()) {
    warnings_.push_back(absl::StrCat(where, ": curves cannot emit light; their area light is left out"));
    return absl::OkStatus();
  }
  if (instanced) {
    warnings_.push_back(
        absl::StrCat(where, ": shapes of an object cannot emit light; its area light is left out"));
    return absl::OkStatus();
  }
  return add_area_lights(shape.area_light(), shape_index);
}

absl::Status SceneBuilder::set_media(const v1::Shape& shape, ShapeRecord& record) {
  const auto interior = medium_index(shape.interior_medium()),
             exterior = medium_index(shape.exterior_medium());
  if (!interior.ok()) return interior.status();
  if (!exterior.ok()) return exterior.status();
  if (*interior == *exterior) return absl::OkStatus();
  record.flags |= kMediumBorder;
  record.interior = *interior, record.exterior = *exterior;
  return absl::OkStatus();
}

absl::Status SceneBuilder::set_alpha(const v1::Shape& shape, ShapeRecord& record) {
  if (!shape.has_alpha()) return absl::OkStatus();
  if (shape.alpha().has_texture()) {
    auto node = texture_node(shape.alpha().texture());
    if (!node.ok()) return node.status();
    record.alpha_texture = *node;
    record.flags |= kHasAlpha;
  } else if (shape.alpha().has_constant() && shape.alpha().constant() < 1) {
    record.alpha = shape.alpha().constant();
    record.flags |= kHasAlpha;
  }
  return absl::OkStatus();
}

absl::Status SceneBuilder::add_mesh(const v1::Shape& shape, const Transform& placed_from_object,
                                    ShapeRecord& record) {
  const auto bytes = blobs_(shape.mesh().blob().digest());
  if (!bytes.ok()) return located(bytes.status(), absl::StrCat("mesh ", shape.mesh().blob().digest()));
  const auto mesh = wire::decode_mesh(bytes->bytes);
  if (!mesh.ok()) return located(mesh.status(), absl::StrCat("mesh ", shape.mesh().blob().digest()));

  ShapeTable& table = arrays_.shapes;
  const std::size_t vertices = table.vertices.size() + mesh->vertex_count();
  const std::size_t triangles = table.triangles.size() / 3 + mesh->triangle_count();
  constexpr std::size_t kMost =
      std::numeric_limits<std::int32_t>::max() / 8;  // the kernels gather floats with 32-bit indices
  if (vertices > kMost || triangles > kMost) {
    return absl::ResourceExhaustedError(
        absl::StrCat("the scene has more than ", kMost, " vertices or triangles"));
  }
  record.kind = ShapeKind::kTriangles;
  record.first_triangle = static_cast<std::int32_t>(table.triangles.size() / 3);
  record.triangle_count = static_cast<std::int32_t>(mesh->triangle_count());
  record.first_vertex = static_cast<std::int32_t>(table.vertices.size());
  record.vertex_count = static_cast<std::int32_t>(mesh->vertex_count());

  if (!append_vertices(*mesh, placed_from_object, table.vertices)) {
    return absl::InvalidArgumentError("a vertex is not finite once it is placed in the world");
  }
  Vertex* placed = table.vertices.data() + record.first_vertex;
  Transform object_from_placed;
  const bool with_normals = !mesh->normals.empty() && placed_from_object.invert(object_from_placed);
  if (with_normals) {
    record.flags |= kHasNormals;
    set_normals(*mesh, object_from_placed, shape.reverse_orientation(), placed);
  }
  if (!mesh->uvs.empty()) record.flags |= kHasUvs;
  const bool turn = shape.reverse_orientation() != (placed_from_object.determinant() < 0);
  append_triangles(*mesh, placed, with_normals, turn, table.triangles);
  return absl::OkStatus();
}

}  // namespace tessera::render
