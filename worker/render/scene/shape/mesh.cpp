// Triangle meshes.
#include <algorithm>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "render/core/stopped.h"
#include "render/scene/shape/closed_mesh.h"
#include "render/scene/shape/geometry.h"
#include "render/scene/shape/shape_kinds.h"
#include "render/scene/values/located.h"
#include "wire/mesh_blob.h"

namespace tessera::render {

namespace {

constexpr const char* kNotFinite = "a vertex is not finite once it is placed in the world";

absl::StatusOr<BlobBytes> blob_of(const v1::BlobRef& mesh, const BlobSource& blobs) {
  auto bytes = blobs(mesh.digest());
  if (!bytes.ok()) return located(bytes.status(), absl::StrCat("mesh ", mesh.digest()));
  return bytes;
}

absl::StatusOr<wire::MeshView> view_of(const v1::BlobRef& mesh, const BlobBytes& blob) {
  auto view = wire::decode_mesh(blob.bytes);
  if (!view.ok()) return located(view.status(), absl::StrCat("mesh ", mesh.digest()));
  return view;
}

/// The kernels gather floats with 32-bit indices.
absl::Status check_size(std::size_t vertices, std::size_t triangles) {
  constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max() / 8;
  if (vertices <= kMost && triangles <= kMost) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat("the scene has more than ", kMost, " vertices or triangles"));
}

/// Makes room for `size` elements: of one large mesh at once, as the array would be copied again and again.
template <class T>
void reserve(std::size_t size, BigArray<T>& array) {
  if (size > array.capacity()) array.reserve(std::max(size, 2 * array.capacity()));
}

/// The vertices of `mesh`, placed by `placed_from_object`, appended. False when one is not finite.
bool append_vertices(const wire::MeshView& mesh, const Transform& placed_from_object, BigArray<Vertex>& out,
                     const std::stop_token& stop) {
  bool sound = true;
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    throw_if_stopped(stop, i);
    const float* xyz = mesh.positions.data() + 3 * i;
    const Imath::V3d p = placed_from_object.apply({xyz[0], xyz[1], xyz[2]});
    Vertex& v = out.emplace_back();
    v.position[0] = static_cast<float>(p.x), v.position[1] = static_cast<float>(p.y),
    v.position[2] = static_cast<float>(p.z);
    for (const float x : v.position) sound = sound && std::isfinite(x);
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
    const Imath::V3d n{m[0] * x + m[4] * y + m[8] * z, m[1] * x + m[5] * y + m[9] * z,
                       m[2] * x + m[6] * y + m[10] * z};
    const double l = n.length();
    const double scale = l > 0 && std::isfinite(l) ? (turn ? -1 : 1) / l : 0;
    vertices[i].normal[0] = static_cast<float>(n.x * scale);
    vertices[i].normal[1] = static_cast<float>(n.y * scale);
    vertices[i].normal[2] = static_cast<float>(n.z * scale);
  }
}

Imath::V3d point(const float (&xyz)[3]) { return {xyz[0], xyz[1], xyz[2]}; }

/// Winds triangles so that cross(p1 - p0, p2 - p0) is the geometric normal: on the side of the shading
/// normals where there are any [pbrt-v4 Triangle::Intersect], else as the mesh has it, turned over when
/// asked.
void append_triangles(const wire::MeshView& mesh, const Vertex* vertices, bool with_normals, bool turn,
                      BigArray<std::uint32_t>& out, const std::stop_token& stop) {
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    throw_if_stopped(stop, i / 3);
    const std::uint32_t a = mesh.indices[i], b = mesh.indices[i + 1], c = mesh.indices[i + 2];
    bool swap = turn;
    if (with_normals) {
      const Imath::V3d p = point(vertices[a].position);
      const Imath::V3d n = (point(vertices[b].position) - p).cross(point(vertices[c].position) - p);
      const double side = n.dot(point(vertices[a].normal)) + n.dot(point(vertices[b].normal)) +
                          n.dot(point(vertices[c].normal));
      if (side != 0) swap = side < 0;
    }
    out.insert(out.end(), {a, swap ? c : b, swap ? b : c});
  }
}

/// Appends the vertices of a later key of the mesh `record`, which follow those before it.
absl::Status append_key(const ShapeToAdd& wanted, const wire::MeshView& mesh,
                        const Transform& placed_from_object) {
  ShapeTable& table = wanted.table;
  const ShapeRecord& record = wanted.record;
  const auto count = static_cast<std::size_t>(record.vertex_count);
  if (mesh.vertex_count() != count) {
    return absl::InvalidArgumentError(absl::StrCat(
        "it has ", mesh.vertex_count(), " vertices where the mesh that it is a key of has ", count));
  }
  const bool with_normals = (record.flags & kHasNormals) != 0;
  if (with_normals && mesh.normals.empty())
    return absl::InvalidArgumentError("it has no normals, where the mesh that it is a key of has some");
  const std::size_t first = table.vertices.size();
  if (auto s = check_size(first + count, 0); !s.ok()) return s;
  if (!append_vertices(mesh, placed_from_object, table.vertices, wanted.stop))
    return absl::InvalidArgumentError(kNotFinite);
  Vertex* const placed = table.vertices.data() + first;
  const Vertex* const own = table.vertices.data() + record.first_vertex;
  for (std::size_t i = 0; i < count; ++i) placed[i].u = own[i].u, placed[i].v = own[i].v;
  Transform object_from_placed;
  if (with_normals && placed_from_object.invert(object_from_placed))
    set_normals(mesh, object_from_placed, wanted.shape.reverse_orientation(), placed);
  return absl::OkStatus();
}

/// The same mesh at all later places.
absl::Status append_places(const ShapeToAdd& wanted, const wire::MeshView& mesh) {
  for (const Transform& place : wanted.later_places) {
    if (auto s = append_key(wanted, mesh, place); !s.ok()) return s;
  }
  return absl::OkStatus();
}

absl::Status add_mesh(const ShapeToAdd& wanted) {
  const v1::TriangleMesh& message = wanted.shape.mesh();
  const auto add = [&](const v1::BlobRef& ref, auto&& append) {
    const auto blob = blob_of(ref, wanted.blobs);
    if (!blob.ok()) return blob.status();
    const auto mesh = view_of(ref, *blob);
    return mesh.ok() ? append(*mesh) : mesh.status();
  };
  if (auto s = add(message.blob(),
                   [&](const wire::MeshView& mesh) {
                     return add_mesh_arrays(wanted.shape, mesh, wanted.placed_from_object, wanted.table,
                                            wanted.record, wanted.stop);
                   });
      !s.ok())
    return s;
  const auto set_keys = [&](int segments) {
    wanted.record.flags |= kDeforms;
    wanted.record.key_segments = segments;
  };
  if (!wanted.later_places.empty()) {
    set_keys(static_cast<int>(wanted.later_places.size()));
    return add(message.blob(), [&](const wire::MeshView& mesh) { return append_places(wanted, mesh); });
  }
  if (message.later_blobs().empty()) return absl::OkStatus();
  if (message.later_blobs_size() > kMostKeySegments) {
    return absl::InvalidArgumentError(
        absl::StrCat("it has ", message.later_blobs_size(), " later keys; at most ", kMostKeySegments));
  }
  set_keys(message.later_blobs_size());
  for (int i = 0; i < message.later_blobs_size(); ++i) {
    const auto status = add(message.later_blobs(i), [&](const wire::MeshView& mesh) {
      return append_key(wanted, mesh, wanted.placed_from_object);
    });
    if (!status.ok()) return located(status, absl::StrCat("later_blobs[", i, "]"));
  }
  return absl::OkStatus();
}

}  // namespace

std::span<const ShapeKindRow> mesh_kinds() {
  static constexpr ShapeKindRow kMesh{
      .message = v1::Shape::kMesh, .add = add_mesh, .why_open = [](const v1::Shape& shape) -> const char* {
        return shape.mesh().later_blobs().empty() ? nullptr
                                                  : "a mesh that deforms cannot be part of a combination";
      }};
  return {&kMesh, 1};
}

absl::Status add_mesh_arrays(const v1::Shape& shape, const wire::MeshView& mesh,
                             const Transform& placed_from_object, ShapeTable& table, ShapeRecord& record,
                             const std::stop_token& stop) {
  const std::size_t vertices = table.vertices.size() + mesh.vertex_count();
  const std::size_t triangles = table.triangles.size() / 3 + mesh.triangle_count();
  if (auto s = check_size(vertices, triangles); !s.ok()) return s;
  record.kind = ShapeKind::kTriangles;
  record.first_triangle = static_cast<std::int32_t>(table.triangles.size() / 3);
  record.triangle_count = static_cast<std::int32_t>(mesh.triangle_count());
  record.first_vertex = static_cast<std::int32_t>(table.vertices.size());
  record.vertex_count = static_cast<std::int32_t>(mesh.vertex_count());

  reserve(vertices, table.vertices);
  reserve(3 * triangles, table.triangles);
  if (!append_vertices(mesh, placed_from_object, table.vertices, stop))
    return absl::InvalidArgumentError(kNotFinite);
  Vertex* placed = table.vertices.data() + record.first_vertex;
  Transform object_from_placed;
  const bool with_normals = !mesh.normals.empty() && placed_from_object.invert(object_from_placed);
  if (with_normals) {
    record.flags |= kHasNormals;
    set_normals(mesh, object_from_placed, shape.reverse_orientation(), placed);
  }
  if (!mesh.uvs.empty()) record.flags |= kHasUvs;
  const bool turn = shape.reverse_orientation() != (placed_from_object.determinant() < 0);
  append_triangles(mesh, placed, with_normals, turn, table.triangles, stop);
  return absl::OkStatus();
}

absl::StatusOr<CsgMesh> closed_mesh_of(const v1::TriangleMesh& mesh, const Transform& transform,
                                       const BlobSource& blobs) {
  const auto blob = blob_of(mesh.blob(), blobs);
  if (!blob.ok()) return blob.status();
  const auto view = view_of(mesh.blob(), *blob);
  if (!view.ok()) return view.status();
  return closed_mesh(*view, transform);
}

absl::StatusOr<std::pair<Imath::V3d, Imath::V3d>> bounds_of_mesh(const v1::TriangleMesh& mesh,
                                                                 const Transform& transform,
                                                                 const BlobSource& blobs) {
  const auto blob = blob_of(mesh.blob(), blobs);
  if (!blob.ok()) return blob.status();
  const auto view = view_of(mesh.blob(), *blob);
  if (!view.ok()) return view.status();
  Imath::V3d low(0, 0, 0), high(0, 0, 0);
  for (std::size_t i = 0; i < view->vertex_count(); ++i) {
    const float* v = view->positions.data() + 3 * i;
    const Imath::V3d p = transform.apply({v[0], v[1], v[2]});
    if (i == 0) low = high = p;
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  return std::pair(low, high);
}

}  // namespace tessera::render
