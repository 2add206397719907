#include "render/scene/shape/csg_solid.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "render/scene/shape/geometry.h"

namespace tessera::render {

namespace {

/// Why a shape is no solid; null for those that are, or may be.
const char* why_not_closed(const v1::Shape& shape) {
  const auto is_cut = [](const auto& round) {
    return round.has_phi_max_degrees() && round.phi_max_degrees() < 360;
  };
  switch (shape.kind_case()) {
    case v1::Shape::kSphere:
      return shape.sphere().has_z_min() || shape.sphere().has_z_max() || is_cut(shape.sphere())
                 ? "a part of a sphere is not closed"
                 : nullptr;
    case v1::Shape::kCylinder:
      return !shape.cylinder().capped() ? "a cylinder without caps is not closed"
             : is_cut(shape.cylinder()) ? "a cylinder that is cut by an angle is not closed"
                                        : nullptr;
    case v1::Shape::kCone:
      return !shape.cone().capped() ? "a cone without caps is not closed"
             : is_cut(shape.cone()) ? "a cone that is cut by an angle is not closed"
                                    : nullptr;
    case v1::Shape::kImplicit:  // by its bounds, a solid of their own
    case v1::Shape::kMesh:
    case v1::Shape::kHalfSpace:
    case v1::Shape::kBox:
    case v1::Shape::kPolyhedron:
    case v1::Shape::kTorus:
    case v1::Shape::kEllipsoid:
      return nullptr;
    case v1::Shape::kDisk:
      return "a disk is not closed";
    case v1::Shape::kPolygon:
      return "a polygon is not closed";
    case v1::Shape::kCurves:
      return "curves are not closed";
    case v1::Shape::kSdfGrid:
      return "a grid of distances may be open, and cannot be combined";
    case v1::Shape::kCsg:
      return "combinations within combinations are parts between `begin` and `end`";
    default:
      return "its kind is missing or unknown";
  }
}

absl::Status check(const v1::Shape& shape) {
  if (const char* const why = why_not_closed(shape)) return absl::InvalidArgumentError(why);
  if (shape.has_area_light()) return absl::InvalidArgumentError("a combination of solids cannot emit light");
  if (shape.has_alpha())
    return absl::InvalidArgumentError("alpha is for the combination, not for an operand");
  if (!shape.interior_medium().empty() || !shape.exterior_medium().empty())
    return absl::InvalidArgumentError("media are for the combination, not for an operand");
  if (!shape.world_from_object_end().elements().empty())
    return absl::InvalidArgumentError("the combination may move; its operands do not move within it");
  return absl::OkStatus();
}

absl::Status add_solid(const v1::Shape& shape, const Transform& placed_from_object, const BlobSource& blobs,
                       ShapeTable& table, ShapeRecord& record, Transform* exact) {
  switch (shape.kind_case()) {
    case v1::Shape::kMesh:
      return add_mesh(shape, placed_from_object, blobs, table, record);
    case v1::Shape::kImplicit:
      if (exact != nullptr) *exact = placed_from_object;
      return add_implicit(shape, placed_from_object, table, record);
    case v1::Shape::kSphere:
      return add_quadric(shape, placed_from_object, table, record, exact);
    case v1::Shape::kBox:
    case v1::Shape::kPolyhedron:
      return add_flat_shape(shape, placed_from_object, false, table, record, exact);
    default:
      return add_round_solid(shape, placed_from_object, table, record, exact);
  }
}

/// The box about the box of half-size `half` about the origin.
CsgBox box_of(const Transform& t, const Imath::V3d& half) {
  CsgBox box;
  for (int a = 0; a < 3; ++a) {
    const double* const row = t.m.data() + std::size_t{4} * static_cast<std::size_t>(a);
    const double reach = std::abs(row[0]) * half.x + std::abs(row[1]) * half.y + std::abs(row[2]) * half.z;
    box.low[a] = row[3] - reach, box.high[a] = row[3] + reach;
  }
  return box;
}

/// Ends where the plane does, if that is straight across an axis.
CsgBox box_of_half_space(const Transform& t) {
  CsgBox box;
  const Imath::V3d at = t.apply({0, 0, 0}),
                   across = t.apply_vector({1, 0, 0}).cross(t.apply_vector({0, 1, 0})),
                   down = t.apply_vector({0, 0, -1});
  for (int a = 0; a < 3; ++a) {
    if (across[(a + 1) % 3] != 0 || across[(a + 2) % 3] != 0) continue;
    if (down[a] < 0) box.high[a] = at[a];
    if (down[a] > 0) box.low[a] = at[a];
  }
  return box;
}

CsgBox box_of(const ShapeRecord& record, const ShapeTable& table, const Transform& t) {
  // The bounds stand beside an implicit surface and have a box.
  if (record.kind == ShapeKind::kImplicit) return {};
  const QuadricRecord& q = table.quadrics[static_cast<std::size_t>(record.quadric)];
  const double r = q.radius, tube = q.inner_radius;
  switch (record.kind) {
    case ShapeKind::kHalfSpace:
      return box_of_half_space(t);
    case ShapeKind::kSphere:
      return box_of(t, {r, r, r});
    case ShapeKind::kTorus:
      return box_of(t, {1 + tube, 1 + tube, tube});
    default:
      return box_of(t, {1, 1, 1});
  }
}

}  // namespace

absl::StatusOr<CsgOperand> read_csg_operand(const v1::Shape& shape, const BlobSource& blobs) {
  if (auto s = check(shape); !s.ok()) return s;
  const auto placed = Transform::from_proto(shape.world_from_object());
  if (!placed.ok()) return placed.status();
  CsgOperand operand;
  operand.combination_from_object = *placed;
  if (shape.has_mesh()) {
    const auto bounds = bounds_of_mesh(shape.mesh(), *placed, blobs);
    if (!bounds.ok()) return bounds.status();
    operand.box = {bounds->first, bounds->second};
    return operand;
  }
  ShapeTable unused;
  ShapeRecord record;
  if (auto s = add_solid(shape, *placed, blobs, unused, record, &operand.combination_from_own); !s.ok())
    return s;
  operand.box = box_of(record, unused, operand.combination_from_own);
  return operand;
}

absl::Status add_csg_operand(const v1::Shape& shape, const Transform& placed_from_object,
                             const BlobSource& blobs, ShapeTable& table, ShapeRecord& record) {
  if (auto s = add_solid(shape, placed_from_object, blobs, table, record, nullptr); !s.ok()) return s;
  record.flags &= ~kFlipNormal;
  return absl::OkStatus();
}

}  // namespace tessera::render
