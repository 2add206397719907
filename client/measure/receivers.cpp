#include "measure/receivers.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "base/nearest_name.h"
#include "import/geometry/transform.h"
#include "measure/fault.h"
#include "wire/mesh_blob.h"

namespace tessera::client {

namespace {

using Imath::V3d;

/// Part of a receiver's width: far enough from a surface that rounding does not put it behind.
constexpr double kOffset = 1e-4;

bool finite(const V3d& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

absl::StatusOr<ReceiverPlace> point_place(const v1::PointReceiver& point, const V3d& up) {
  ReceiverPlace place;
  const V3d normal = point.has_normal() ? vector_of(point.normal()) : up,
            position = vector_of(point.position());
  if (!finite(normal) || !(normal.length() > 0)) return fault("a normal has no direction");
  if (!finite(position)) return fault("a position is not finite");
  place.normal = normal.normalized();
  place.positions = {position};
  *place.probe.mutable_point() = point.position();
  *place.probe.mutable_axis() = point_of(place.normal);
  return place;
}

absl::StatusOr<ReceiverPlace> plane_place(const v1::PlaneReceiver& plane) {
  ReceiverPlace place;
  const V3d corner = vector_of(plane.corner()), u = vector_of(plane.edge_u()), v = vector_of(plane.edge_v());
  const V3d across = u % v;
  if (!finite(corner) || !finite(across) || !(across.length() > 0)) return fault("a plane has no area");
  const std::uint32_t columns = std::max(1u, plane.columns()), rows = std::max(1u, plane.rows());
  constexpr std::uint64_t kMostCells = std::uint64_t{1} << 24;
  const double readings_bytes = static_cast<double>(sizeof(Reading)) * columns * rows;
  if (std::uint64_t{columns} * rows > kMostCells)
    return absl::ResourceExhaustedError(absl::StrCat("a plane of ", columns, " x ", rows, " cells takes ",
                                                     std::round(readings_bytes / 1e8) / 10, " GB; ",
                                                     kMostCells, " cells are the most"));
  place.normal = across.normalized() * (plane.flip() ? -1.0 : 1.0);
  place.area = across.length() / columns / rows;
  v1::ProbePlane& made = *place.probe.mutable_plane();
  *made.mutable_corner() = plane.corner();
  *made.mutable_edge_u() = plane.edge_u();
  *made.mutable_edge_v() = plane.edge_v();
  made.set_columns(columns), made.set_rows(rows);
  made.set_at_middles(plane.at_middles());
  *place.probe.mutable_axis() = point_of(place.normal);
  place.probe.set_offset(kOffset * std::min(u.length() / columns, v.length() / rows));
  for (std::uint32_t row = 0; row < rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column)
      place.positions.push_back(corner + u * ((column + 0.5) / columns) + v * ((row + 0.5) / rows));
  }
  place.plane = MeasuredPlane{corner, u, v, columns, rows, 0};
  return place;
}

/// The length that a map gives to axes; nothing where it is another for some.
std::optional<double> even_scale(const Imath::M44d& map) {
  double lengths[3];
  for (int a = 0; a < 3; ++a) lengths[a] = V3d(map[a][0], map[a][1], map[a][2]).length();
  const auto [least, most] = std::minmax_element(std::begin(lengths), std::end(lengths));
  if (!(*least > 0) || *most > *least * (1 + 1e-6)) return std::nullopt;
  return lengths[0];
}

absl::StatusOr<ReceiverPlace> mesh_place(const v1::Shape& shape, const ImportedScene& scene) {
  const std::string& digest = shape.mesh().blob().digest();
  const auto blob = std::ranges::find(scene.blobs, digest, [](const SceneBlob& b) { return b.ref.digest(); });
  if (blob == scene.blobs.end()) return fault("its mesh is not there");
  if (!blob->file.empty()) return fault("its mesh is a file of blobs, which is not read");
  const auto mesh = wire::decode_mesh(blob->bytes);
  if (!mesh.ok()) return mesh.status();
  const Imath::M44d map = matrix_of(shape.world_from_object());
  ReceiverPlace place;
  V3d middle(0);
  const auto corner = [&](std::uint32_t vertex) {
    const float* const p = mesh->positions.data() + std::size_t{3} * vertex;
    return V3d(p[0], p[1], p[2]) * map;
  };
  for (std::size_t t = 0; t < mesh->triangle_count(); ++t) {
    const std::uint32_t* const index = mesh->indices.data() + 3 * t;
    const V3d a = corner(index[0]), b = corner(index[1]), c = corner(index[2]);
    const double area = ((b - a) % (c - a)).length() / 2;
    place.area += area;
    middle += (a + b + c) * (area / 3);
  }
  if (!(place.area > 0)) return fault("its mesh has no area");
  place.positions = {middle / place.area};
  v1::ProbeMesh& made = *place.probe.mutable_mesh();
  *made.mutable_mesh() = shape.mesh().blob();
  *made.mutable_world_from_mesh() = shape.world_from_object();
  return place;
}

absl::StatusOr<ReceiverPlace> round_place(const v1::Shape& shape) {
  const Imath::M44d map = matrix_of(shape.world_from_object());
  const auto scale = even_scale(map);
  if (!scale)
    return fault("it is stretched: only meshes, and spheres and disks that keep their form, are read");
  ReceiverPlace place;
  if (shape.has_sphere()) {
    const v1::Sphere& sphere = shape.sphere();
    if (sphere.has_z_min() || sphere.has_z_max() || sphere.has_phi_max_degrees())
      return fault("it is a part of a sphere: only whole ones are read");
    const double radius = sphere.radius() * *scale;
    place.positions = {V3d(0) * map};
    place.area = 4 * std::numbers::pi * radius * radius;
    *place.probe.mutable_sphere()->mutable_middle() = point_of(place.positions[0]);
    place.probe.mutable_sphere()->set_radius(radius);
    return place;
  }
  const v1::Disk& disk = shape.disk();
  if (disk.inner_radius() > 0 || disk.has_phi_max_degrees())
    return fault("it is a part of a disk: only whole ones are read");
  const double radius = disk.radius() * *scale;
  place.positions = {V3d(0, 0, disk.height()) * map};
  place.normal = transformed_vector(V3d(1, 0, 0), map) % transformed_vector(V3d(0, 1, 0), map);
  place.normal.normalize();
  place.area = std::numbers::pi * radius * radius;
  *place.probe.mutable_disk()->mutable_middle() = point_of(place.positions[0]);
  place.probe.mutable_disk()->set_radius(radius);
  *place.probe.mutable_axis() = point_of(place.normal);
  return place;
}

std::string all_names(const ImportedScene& scene) {
  std::set<std::string> names;
  for (const v1::Shape& shape : scene.scene.shapes())
    if (!shape.name().empty()) names.insert(shape.name());
  if (names.empty()) return "the scene's shapes have no names";
  std::string list = "the scene has";
  constexpr std::size_t kMostNames = 12;
  std::size_t told = 0;
  for (const std::string& name : names) {
    if (told == kMostNames) {
      absl::StrAppend(&list, " and ", names.size() - told, " more");
      break;
    }
    absl::StrAppend(&list, told++ == 0 ? " '" : ", '", name, "'");
  }
  return list;
}

}  // namespace

V3d vector_of(const v1::Point3& p) { return {p.x(), p.y(), p.z()}; }

v1::Point3 point_of(const V3d& v) {
  v1::Point3 p;
  p.set_x(v.x), p.set_y(v.y), p.set_z(v.z);
  return p;
}

std::vector<const v1::Shape*> shapes_named(const ImportedScene& scene, const std::string& name) {
  std::vector<const v1::Shape*> found;
  for (const v1::Shape& shape : scene.scene.shapes())
    if (shape.name() == name) found.push_back(&shape);
  return found;
}

absl::StatusOr<ReceiverPlace> surface_of(const v1::Shape& shape, const ImportedScene& scene, bool inside) {
  if (shape.motion_size() > 0 || shape.has_world_from_object_end() || shape.mesh().later_blobs_size() > 0)
    return fault("it moves: only surfaces that stand still are read");
  absl::StatusOr<ReceiverPlace> place = fault("only meshes, spheres and disks are read");
  if (shape.has_mesh()) place = mesh_place(shape, scene);
  if (shape.has_sphere() || shape.has_disk()) place = round_place(shape);
  if (!place.ok()) return place;
  const bool turned = inside != shape.reverse_orientation();
  place->probe.set_inward(turned);
  if (shape.has_disk() && turned) {
    place->normal = -place->normal;
    *place->probe.mutable_axis() = point_of(place->normal);
  }
  place->probe.set_offset(kOffset * std::sqrt(place->area));
  return place;
}

absl::StatusOr<ReceiverPlace> place_of(const v1::Receiver& receiver, const ImportedScene& scene,
                                       const V3d& up) {
  const auto made = [&]() -> absl::StatusOr<ReceiverPlace> {
    switch (receiver.kind_case()) {
      case v1::Receiver::kPoint:
        return point_place(receiver.point(), up);
      case v1::Receiver::kPlane:
        return plane_place(receiver.plane());
      case v1::Receiver::kSurface: {
        const std::string& name = receiver.surface().shape();
        const std::vector<const v1::Shape*> shapes = shapes_named(scene, name);
        if (shapes.empty()) return fault(absl::StrCat("there is no shape '", name, "'; ", all_names(scene)));
        if (shapes.size() > 1)
          return fault(absl::StrCat(shapes.size(), " shapes have the name '", name, "': one is read"));
        auto surface = surface_of(*shapes.front(), scene, receiver.surface().inside());
        if (!surface.ok())
          return absl::Status(surface.status().code(),
                              absl::StrCat("shape '", name, "': ", surface.status().message()));
        return surface;
      }
      default:
        return fault("a receiver is neither point, plane nor surface");
    }
  };
  auto place = made();
  if (!place.ok() || !receiver.has_offset()) return place;
  if (!(receiver.offset() >= 0) || !std::isfinite(receiver.offset()))
    return fault(absl::StrCat("an offset of ", receiver.offset(), " is below 0"));
  place->probe.set_offset(receiver.offset());
  return place;
}

ReceiverPlace other_side(ReceiverPlace place) {
  place.normal = -place.normal;
  place.probe.set_inward(!place.probe.inward());
  if (place.probe.has_axis()) *place.probe.mutable_axis() = point_of(place.normal);
  return place;
}

}  // namespace tessera::client
