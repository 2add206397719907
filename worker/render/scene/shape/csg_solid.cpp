#include "render/scene/shape/csg_solid.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "render/scene/shape/geometry.h"
#include "render/scene/shape/shape_kinds.h"

namespace tessera::render {

namespace {

absl::Status check(const v1::Shape& shape) {
  const ShapeKindRow* const row = find_shape_kind(shape);
  if (row == nullptr) return absl::InvalidArgumentError("its kind is missing or unknown");
  const char* const why = row->why_open == nullptr ? nullptr : row->why_open(shape);
  if (why != nullptr) return absl::InvalidArgumentError(why);
  if (shape.has_area_light()) return absl::InvalidArgumentError("a combination of solids cannot emit light");
  if (shape.has_alpha())
    return absl::InvalidArgumentError("alpha is for the combination, not for an operand");
  if (!shape.interior_medium().empty() || !shape.exterior_medium().empty())
    return absl::InvalidArgumentError("media are for the combination, not for an operand");
  if (!shape.world_from_object_end().elements().empty() || !shape.motion().empty())
    return absl::InvalidArgumentError("the combination may move; its operands do not move within it");
  return absl::OkStatus();
}

constexpr ShapeKindRow kCombination{
    .message = v1::Shape::kCsg,
    .without_light = [](const v1::Shape&) { return "a combination of solids"; },
    .why_open =
        [](const v1::Shape&) {
          return "combinations within combinations are parts between `begin` and `end`";
        }};

}  // namespace

std::span<const ShapeKindRow> combination_kinds() { return {&kCombination, 1}; }

CsgBox box_about(const Transform& t, const Imath::V3d& half) {
  CsgBox box;
  for (int a = 0; a < 3; ++a) {
    const double* const row = t.m.data() + std::size_t{4} * static_cast<std::size_t>(a);
    const double reach = std::abs(row[0]) * half.x + std::abs(row[1]) * half.y + std::abs(row[2]) * half.z;
    box.low[a] = row[3] - reach, box.high[a] = row[3] + reach;
  }
  return box;
}

CsgBox box_of_unit_cube(const QuadricRecord&, const Transform& placed) {
  return box_about(placed, {1, 1, 1});
}

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
  const ShapeKindRow& kind = *find_shape_kind(shape);
  const ShapeToAdd wanted{.shape = shape,
                          .placed_from_object = *placed,
                          .blobs = blobs,
                          .table = unused,
                          .record = record,
                          .exact = &operand.combination_from_own};
  if (auto s = kind.add(wanted); !s.ok()) return s;
  if (kind.box != nullptr) operand.box = kind.box(unused.quadrics.back(), operand.combination_from_own);
  return operand;
}

absl::Status add_csg_operand(const v1::Shape& shape, const Transform& placed_from_object,
                             const BlobSource& blobs, ShapeTable& table, ShapeRecord& record) {
  if (auto s = add_geometry(shape, placed_from_object, false, blobs, table, record); !s.ok()) return s;
  record.flags &= ~kFlipNormal;
  return absl::OkStatus();
}

}  // namespace tessera::render
