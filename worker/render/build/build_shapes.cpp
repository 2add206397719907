#include <algorithm>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "render/build/scene_builder.h"

namespace tessera::render {

namespace {

std::string place(const char* what, int index, const std::string& name) {
  return name.empty() ? absl::StrCat(what, " ", index) : absl::StrCat(what, " ", index, " (", name, ")");
}

bool finite(float x) { return std::isfinite(x); }

/// The vertices of `mesh`, placed by `placed_from_object`, appended. False when one is not finite.
bool append_vertices(const wire::MeshView& mesh, const Transform& placed_from_object, std::vector<Vertex>& out) {
  bool sound = true;
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    const float* xyz = mesh.positions.data() + 3 * i;
    const Point p = placed_from_object.apply({xyz[0], xyz[1], xyz[2]});
    Vertex& v = out.emplace_back();
    v.position[0] = static_cast<float>(p.x), v.position[1] = static_cast<float>(p.y), v.position[2] = static_cast<float>(p.z);
    for (const float x : v.position) sound = sound && finite(x);
    if (!mesh.uvs.empty()) v.u = mesh.uvs[2 * i], v.v = mesh.uvs[2 * i + 1];
  }
  return sound;
}

/// Shading normals through the inverse transpose, turned over when asked.
void set_normals(const wire::MeshView& mesh, const Transform& object_from_placed, bool turn, Vertex* vertices) {
  const auto& m = object_from_placed.m;
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    const double x = mesh.normals[3 * i], y = mesh.normals[3 * i + 1], z = mesh.normals[3 * i + 2];
    const Point n{m[0] * x + m[4] * y + m[8] * z, m[1] * x + m[5] * y + m[9] * z, m[2] * x + m[6] * y + m[10] * z};
    const double l = length(n);
    const double scale = l > 0 && std::isfinite(l) ? (turn ? -1 : 1) / l : 0;
    vertices[i].normal[0] = static_cast<float>(n.x * scale);
    vertices[i].normal[1] = static_cast<float>(n.y * scale);
    vertices[i].normal[2] = static_cast<float>(n.z * scale);
  }
}

Point point(const float (&xyz)[3]) { return {xyz[0], xyz[1], xyz[2]}; }

/// Winds triangles so that cross(p1 - p0, p2 - p0) is the geometric normal: on the side of the shading normals where
/// there are any [pbrt-v4 Triangle::Intersect], else as the mesh has it, turned over when asked.
void append_triangles(const wire::MeshView& mesh, const Vertex* vertices, bool with_normals, bool turn,
                      std::vector<std::uint32_t>& out) {
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

absl::Status SceneBuilder::build_shapes() {
  int index = 0;
  for (const v1::Shape& shape : scene_.shapes()) {
    const std::string where = place("shape", index++, shape.name());
    if (auto s = build_shape(shape, render_from_world_, false, where); !s.ok()) return located(s, where);
  }
  ShapeTable& table = tables_.shapes;
  table.world_shape_count = static_cast<std::int32_t>(table.shapes.size());
  for (const v1::Object& object : scene_.objects()) {
    if (!objects_.emplace(object.name(), static_cast<int>(objects_.size())).second) {
      return absl::InvalidArgumentError(absl::StrCat("object '", object.name(), "': the name is used twice"));
    }
    ObjectRange range{static_cast<std::int32_t>(table.shapes.size()), 0};
    index = 0;
    for (const v1::Shape& shape : object.shapes()) {
      const std::string where = absl::StrCat("object '", object.name(), "', ", place("shape", index++, shape.name()));
      if (auto s = build_shape(shape, Transform{}, true, where); !s.ok()) return located(s, where);
    }
    range.shape_count = static_cast<std::int32_t>(table.shapes.size()) - range.first_shape;
    table.objects.push_back(range);
  }
  return build_instances();
}

absl::Status SceneBuilder::build_shape(const v1::Shape& shape, const Transform& placed_from_world, bool instanced,
                                       const std::string& where) {
  ShapeRecord record;
  const auto material = material_index(shape.material());
  if (!material.ok()) return material.status();
  record.material = *material;
  const bool interface = tables_.materials.materials[*material].kind == BsdfKind::kInterface;
  if (auto s = set_media(shape, record); !s.ok()) return s;
  // A surface of nothing matters only as the border of a medium.
  if (interface && !shape.has_area_light() && !(record.flags & kMediumBorder)) return absl::OkStatus();

  auto world_from_object = Transform::from_proto(shape.world_from_object());
  if (!world_from_object.ok()) return world_from_object.status();
  const Transform placed_from_object = placed_from_world * *world_from_object;
  if (auto s = set_alpha(shape, record); !s.ok()) return s;
  switch (shape.kind_case()) {
    case v1::Shape::kMesh:
      if (auto s = add_mesh(shape, placed_from_object, record); !s.ok()) return s;
      break;
    case v1::Shape::kSphere:
    case v1::Shape::kDisk:
    case v1::Shape::kCylinder:
      if (record.flags & kHasAlpha) warnings_.push_back(absl::StrCat(where, ": alpha is for meshes only; left out"));
      if (auto s = add_quadric(shape, placed_from_object, record); !s.ok()) return s;
      break;
    case v1::Shape::kSdfGrid:
      if (auto s = add_sdf_grid(shape, placed_from_object, record); !s.ok()) return s;
      break;
    case v1::Shape::kCurves:
      if (auto s = add_curves(shape, placed_from_object, record); !s.ok()) return s;
      break;
    case v1::Shape::KIND_NOT_SET: return absl::InvalidArgumentError("its kind is missing or unknown");
  }
  const auto shape_index = static_cast<std::int32_t>(tables_.shapes.shapes.size());
  tables_.shapes.shapes.push_back(record);
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
    warnings_.push_back(absl::StrCat(where, ": shapes of an object cannot emit light; its area light is left out"));
    return absl::OkStatus();
  }
  return add_area_lights(shape.area_light(), shape_index);
}

absl::Status SceneBuilder::set_media(const v1::Shape& shape, ShapeRecord& record) {
  const auto interior = medium_index(shape.interior_medium()), exterior = medium_index(shape.exterior_medium());
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

absl::Status SceneBuilder::add_mesh(const v1::Shape& shape, const Transform& placed_from_object, ShapeRecord& record) {
  const auto bytes = blobs_(shape.mesh().blob().digest());
  if (!bytes.ok()) return located(bytes.status(), absl::StrCat("mesh ", shape.mesh().blob().digest()));
  const auto mesh = wire::decode_mesh(bytes->bytes);
  if (!mesh.ok()) return located(mesh.status(), absl::StrCat("mesh ", shape.mesh().blob().digest()));

  ShapeTable& table = tables_.shapes;
  const std::size_t vertices = table.vertices.size() + mesh->vertex_count();
  const std::size_t triangles = table.triangles.size() / 3 + mesh->triangle_count();
  constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max() / 8;  // the kernels gather floats with 32-bit indices
  if (vertices > kMost || triangles > kMost) {
    return absl::ResourceExhaustedError(absl::StrCat("the scene has more than ", kMost, " vertices or triangles"));
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

absl::Status SceneBuilder::build_instances() {
  int index = 0;
  for (const v1::Instance& instance : scene_.instances()) {
    const std::string where = place("instance", index++, instance.object());
    const auto object = objects_.find(instance.object());
    if (object == objects_.end()) {
      return absl::InvalidArgumentError(absl::StrCat(where, ": object '", instance.object(), "' does not exist"));
    }
    auto world_from_instance = Transform::from_proto(instance.world_from_instance());
    if (!world_from_instance.ok()) return located(world_from_instance.status(), where);
    const Transform render_from_instance = render_from_world_ * *world_from_instance;
    Transform instance_from_render;
    if (!render_from_instance.invert(instance_from_render)) {
      warnings_.push_back(absl::StrCat(where, ": its transform is singular; left out"));
      continue;
    }
    tables_.shapes.instances.push_back(
        {render_from_instance.to_affine(), instance_from_render.to_affine(), object->second, {}});
  }
  return absl::OkStatus();
}

}  // namespace tessera::render
