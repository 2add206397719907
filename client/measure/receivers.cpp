#include "measure/receivers.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "base/nearest_name.h"
#include "measure/fault.h"
#include "measure/surfaces.h"

namespace tessera::client {

namespace {

using Imath::V3d;

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
  place.probe.set_offset(kReceiverOffset * std::min(u.length() / columns, v.length() / rows));
  for (std::uint32_t row = 0; row < rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column)
      place.positions.push_back(corner + u * ((column + 0.5) / columns) + v * ((row + 0.5) / rows));
  }
  place.plane = MeasuredPlane{corner, u, v, columns, rows, 0};
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
        const bool inside = receiver.surface().inside();
        auto surface = receiver.surface().by_triangle() ? triangles_of(*shapes.front(), scene, inside)
                                                        : surface_of(*shapes.front(), scene, inside);
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
  for (CellTriangle& triangle : place->triangles) triangle.offset = receiver.offset();
  return place;
}

ReceiverPlace other_side(ReceiverPlace place) {
  place.normal = -place.normal;
  place.probe.set_inward(!place.probe.inward());
  if (place.probe.has_axis()) *place.probe.mutable_axis() = point_of(place.normal);
  return place;
}

}  // namespace tessera::client
