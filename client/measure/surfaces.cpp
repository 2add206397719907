#include "measure/surfaces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "import/geometry/transform.h"
#include "import/input/blob_collector.h"
#include "import/input/input_file.h"
#include "measure/fault.h"
#include "measure/plan.h"
#include "measure/sampling.h"
#include "wire/mesh_blob.h"

namespace tessera::client {

namespace {

using Imath::V3d;

/// A triangle mesh in the object space of its shape, and its blob, which the scene may have already.
struct ObjectMesh {
  std::vector<V3d> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  v1::BlobRef ref;
  std::vector<SceneBlob> blobs;
};

absl::StatusOr<ObjectMesh> mesh_of_blob(const v1::TriangleMesh& message, const ImportedScene& scene) {
  const std::string& digest = message.blob().digest();
  const auto blob = std::ranges::find(scene.blobs, digest, [](const SceneBlob& b) { return b.ref.digest(); });
  if (blob == scene.blobs.end()) return fault("its mesh is not there");
  InputFile file;
  if (!blob->file.empty()) {
    auto opened = InputFile::open(blob->file);
    if (!opened.ok()) return opened.status();
    file = *std::move(opened);
  }
  const auto view = wire::decode_mesh(blob->file.empty() ? std::string_view(blob->bytes) : file.bytes());
  if (!view.ok()) return view.status();
  ObjectMesh mesh;
  for (std::size_t i = 0; i < view->vertex_count(); ++i) {
    const float* const p = view->positions.data() + 3 * i;
    mesh.vertices.emplace_back(p[0], p[1], p[2]);
  }
  for (std::size_t t = 0; t < view->triangle_count(); ++t) {
    const std::uint32_t* const index = view->indices.data() + 3 * t;
    mesh.triangles.push_back({index[0], index[1], index[2]});
  }
  mesh.ref = message.blob();
  mesh.ref.clear_path();
  return mesh;
}

/// Adds a convex face as a fan about its first corner.
void add_fan(std::span<const V3d> corners, ObjectMesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), corners.begin(), corners.end());
  for (std::uint32_t i = 2; i < corners.size(); ++i)
    mesh.triangles.push_back({first, first + i - 1, first + i});
}

/// Whether corners all turn the same way, once around. Their plane is `normal`'s.
bool is_convex(const std::vector<V3d>& corners, const V3d& normal) {
  const std::size_t n = corners.size();
  const double least = -1e-6 * normal.length2();
  const auto turns_left = [&](std::size_t a, std::size_t b, std::size_t c) {
    const V3d across = (corners[b % n] - corners[a % n]) % (corners[c % n] - corners[a % n]);
    return (across ^ normal) >= least;
  };
  for (std::size_t i = 0; i < n; ++i) {
    // The fan tells convex polygons from stars, which turn the same way, too.
    if (!turns_left(i, i + 1, i + 2) || (i + 2 < n && !turns_left(0, i + 1, i + 2))) return false;
  }
  return true;
}

absl::StatusOr<ObjectMesh> mesh_of_polygon(const v1::Polygon& polygon) {
  std::vector<V3d> corners;
  for (int i = 0; i + 2 < polygon.corners_size(); i += 3)
    corners.emplace_back(polygon.corners(i), polygon.corners(i + 1), polygon.corners(i + 2));
  V3d normal(0);
  for (std::size_t i = 2; i < corners.size(); ++i)
    normal += (corners[i - 1] - corners[0]) % (corners[i] - corners[0]);
  if (!(normal.length() > 0)) return fault("its polygon has no area");
  if (!is_convex(corners, normal)) return fault("of polygons, only convex ones are read");
  ObjectMesh mesh;
  add_fan(corners, mesh);
  return mesh;
}

absl::StatusOr<ObjectMesh> mesh_of_box(const v1::Box& box) {
  if (box.low_size() != 3 || box.high_size() != 3) return fault("its box lacks corners");
  const V3d low(box.low(0), box.low(1), box.low(2)), high(box.high(0), box.high(1), box.high(2));
  const V3d middle = (low + high) / 2, half = (high - low) / 2;
  ObjectMesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      V3d n(0), a(0), b(0);
      n[axis] = side * half[axis];
      a[(axis + 1) % 3] = side * half[(axis + 1) % 3];
      b[(axis + 2) % 3] = half[(axis + 2) % 3];
      const V3d face = middle + n;
      const std::array<V3d, 4> corners{face - a - b, face + a - b, face + a + b, face - a + b};
      add_fan(corners, mesh);
    }
  }
  return mesh;
}

bool has_triangles(const v1::Shape& shape) {
  return shape.has_mesh() || shape.has_polygon() || shape.has_box();
}

absl::StatusOr<ObjectMesh> mesh_of(const v1::Shape& shape, const ImportedScene& scene) {
  if (shape.has_mesh()) return mesh_of_blob(shape.mesh(), scene);
  auto mesh = shape.has_polygon() ? mesh_of_polygon(shape.polygon()) : mesh_of_box(shape.box());
  if (!mesh.ok()) return mesh;
  wire::MeshData data;
  for (const V3d& vertex : mesh->vertices) append_floats(data.positions, vertex);
  for (const std::array<std::uint32_t, 3>& triangle : mesh->triangles)
    data.indices.insert(data.indices.end(), triangle.begin(), triangle.end());
  BlobCollector blobs;
  mesh->ref = blobs.add_bytes(wire::encode_mesh(data));
  mesh->blobs = blobs.take();
  return mesh;
}

/// The triangles in world space, wound counterclockwise about their geometric normals.
std::vector<CellTriangle> placed_triangles(const v1::Shape& shape, const ObjectMesh& mesh) {
  const Imath::M44d map = matrix_of(shape.world_from_object());
  const bool mirrors = determinant3(map) < 0;
  std::vector<CellTriangle> placed;
  for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles) {
    const V3d a = mesh.vertices[triangle[0]] * map;
    CellTriangle& added = placed.emplace_back(CellTriangle{.corner = a,
                                                           .edge_u = mesh.vertices[triangle[1]] * map - a,
                                                           .edge_v = mesh.vertices[triangle[2]] * map - a});
    if (mirrors) std::swap(added.edge_u, added.edge_v);
  }
  return placed;
}

V3d middle_of(const CellTriangle& triangle) {
  return triangle.corner + (triangle.edge_u + triangle.edge_v) / 3;
}

absl::StatusOr<ReceiverPlace> mesh_place(const v1::Shape& shape, const ImportedScene& scene) {
  auto mesh = mesh_of(shape, scene);
  if (!mesh.ok()) return mesh.status();
  ReceiverPlace place;
  V3d middle(0);
  for (const CellTriangle& triangle : placed_triangles(shape, *mesh)) {
    place.area += triangle.area();
    middle += middle_of(triangle) * triangle.area();
  }
  if (!(place.area > 0) || !std::isfinite(place.area)) return fault("its mesh has no area");
  place.positions = {middle / place.area};
  *place.probe.mutable_mesh()->mutable_mesh() = mesh->ref;
  *place.probe.mutable_mesh()->mutable_world_from_mesh() = shape.world_from_object();
  place.blobs = std::move(mesh->blobs);
  return place;
}

/// The length of `count` axes under a map; nothing where they differ, or do not stay at right angles.
std::optional<double> even_scale(const Imath::M44d& map, const V3d& axes, int count) {
  constexpr double kEqual = 1e-6;
  std::array<V3d, 3> images;
  for (int a = 0; a < count; ++a)
    images[static_cast<std::size_t>(a)] = V3d(map[a][0], map[a][1], map[a][2]) * axes[a];
  const double length = images[0].length();
  if (!(length > 0) || !std::isfinite(length)) return std::nullopt;
  for (std::size_t a = 0; a < static_cast<std::size_t>(count); ++a) {
    if (std::abs(images[a].length() / length - 1) > kEqual) return std::nullopt;
    for (std::size_t b = 0; b < a; ++b)
      if (std::abs(images[a] ^ images[b]) > kEqual * length * length) return std::nullopt;
  }
  return length;
}

bool is_whole(const v1::Sphere& sphere) {
  return !(sphere.has_z_min() && sphere.z_min() > -sphere.radius()) &&
         !(sphere.has_z_max() && sphere.z_max() < sphere.radius()) &&
         !(sphere.has_phi_max_degrees() && sphere.phi_max_degrees() < 360);
}

absl::StatusOr<ReceiverPlace> ball_place(const v1::Shape& shape) {
  V3d radii(shape.sphere().radius());
  if (shape.has_ellipsoid()) {
    const auto& message = shape.ellipsoid().radii();
    if (message.size() != 3) return fault("its ellipsoid lacks radii");
    radii = {message[0], message[1], message[2]};
  } else if (!is_whole(shape.sphere())) {
    return fault("it is a part of a sphere: only whole ones are read");
  }
  const Imath::M44d map = matrix_of(shape.world_from_object());
  const auto radius = even_scale(map, radii, 3);
  if (!radius) return fault("it is no ball in the world: stretched spheres are not read");
  ReceiverPlace place;
  place.positions = {V3d(0) * map};
  place.area = 4 * std::numbers::pi * *radius * *radius;
  *place.probe.mutable_sphere()->mutable_middle() = point_of(place.positions[0]);
  place.probe.mutable_sphere()->set_radius(*radius);
  // Normals of mirrored spheres look inwards, those of ellipsoids do not (shape.proto).
  place.probe.set_inward(shape.has_sphere() && determinant3(map) < 0);
  return place;
}

absl::StatusOr<ReceiverPlace> disk_place(const v1::Shape& shape) {
  const v1::Disk& disk = shape.disk();
  if (disk.inner_radius() > 0 || (disk.has_phi_max_degrees() && disk.phi_max_degrees() < 360))
    return fault("it is a part of a disk: only whole ones are read");
  const Imath::M44d map = matrix_of(shape.world_from_object());
  const auto radius = even_scale(map, V3d(disk.radius()), 2);
  if (!radius) return fault("it is no disk in the world: stretched disks are not read");
  ReceiverPlace place;
  place.positions = {V3d(0, 0, disk.height()) * map};
  place.normal = transformed_vector(V3d(1, 0, 0), map) % transformed_vector(V3d(0, 1, 0), map);
  place.normal.normalize();
  place.area = std::numbers::pi * *radius * *radius;
  *place.probe.mutable_disk()->mutable_middle() = point_of(place.positions[0]);
  place.probe.mutable_disk()->set_radius(*radius);
  *place.probe.mutable_axis() = point_of(place.normal);
  return place;
}

absl::Status check_at_rest(const v1::Shape& shape) {
  if (shape.motion_size() > 0 || shape.has_world_from_object_end() || shape.mesh().later_blobs_size() > 0)
    return fault("it moves: only surfaces that stand still are read");
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<ReceiverPlace> surface_of(const v1::Shape& shape, const ImportedScene& scene, bool inside) {
  if (absl::Status s = check_at_rest(shape); !s.ok()) return s;
  absl::StatusOr<ReceiverPlace> place =
      fault("only meshes, convex polygons, boxes, spheres and disks are read");
  if (has_triangles(shape)) place = mesh_place(shape, scene);
  if (shape.has_sphere() || shape.has_ellipsoid()) place = ball_place(shape);
  if (shape.has_disk()) place = disk_place(shape);
  if (!place.ok()) return place;
  const bool turned = (inside != shape.reverse_orientation()) != place->probe.inward();
  place->probe.set_inward(turned);
  if (shape.has_disk() && turned) {
    place->normal = -place->normal;
    *place->probe.mutable_axis() = point_of(place->normal);
  }
  place->probe.set_offset(kReceiverOffset * std::sqrt(place->area));
  return place;
}

absl::StatusOr<ReceiverPlace> triangles_of(const v1::Shape& shape, const ImportedScene& scene, bool inside) {
  if (absl::Status s = check_at_rest(shape); !s.ok()) return s;
  if (!has_triangles(shape))
    return fault("it has no triangles: those of meshes, polygons and boxes are read");
  auto mesh = mesh_of(shape, scene);
  if (!mesh.ok()) return mesh.status();
  constexpr std::size_t kMostTriangles = std::size_t{1} << 22;
  constexpr std::size_t kBytes =
      sizeof(Reading) + sizeof(PlannedReading) + sizeof(CellTerm) + sizeof(CellSums) + sizeof(CellTriangle);
  const std::size_t count = mesh->triangles.size();
  if (count > kMostTriangles)
    return absl::ResourceExhaustedError(absl::StrCat(
        "figures of ", count, " triangles take ", std::round(static_cast<double>(kBytes * count) / 1e8) / 10,
        " GB; ", kMostTriangles, " triangles are the most: the whole surface has one figure"));
  ReceiverPlace place;
  place.triangles = placed_triangles(shape, *mesh);
  for (const CellTriangle& triangle : place.triangles) place.area += triangle.area();
  if (!(place.area > 0) || !std::isfinite(place.area)) return fault("its mesh has no area");
  // Flat triangles of a fine mesh are received as far off as rounding asks for.
  const double least = 1e-6 * std::sqrt(place.area);
  for (CellTriangle& triangle : place.triangles) {
    triangle.offset = std::max(least, kReceiverOffset * std::sqrt(triangle.area()));
    place.positions.push_back(middle_of(triangle));
  }
  const bool turned = inside != shape.reverse_orientation();
  const Imath::M44d map = matrix_of(shape.world_from_object());
  for (V3d& vertex : mesh->vertices) vertex = vertex * map;
  place.mesh = MeasuredMesh{.shape = shape.name(),
                            .vertices = std::move(mesh->vertices),
                            .triangles = std::move(mesh->triangles),
                            .turned = turned != (determinant3(map) < 0)};
  // Probes of single triangles take their places and offsets; that of all tells the rest.
  place.probe.set_offset(least);
  place.probe.mutable_mesh();
  place.probe.set_inward(turned);
  place.blobs = {unit_triangle()};
  return place;
}

}  // namespace tessera::client
