// One operand of a combination of solids.
#pragma once

#include "absl/status/statusor.h"
#include "render/scene/blob_source.h"
#include "render/scene/placement/transform.h"
#include "render/shape/shape_table.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

/// A box along the axes; sides may be infinite.
struct CsgBox {
  Imath::V3d low{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}, high{HUGE_VAL, HUGE_VAL, HUGE_VAL};

  bool is_empty() const { return !(low.x < high.x && low.y < high.y && low.z < high.z); }
};

/// The box about a box of half-size `half` about the origin of a space that is placed so.
CsgBox box_about(const Transform& placed, const Imath::V3d& half);

/// Placement and bounds of an operand in the space of the combination, before that has its size.
struct CsgOperand {
  Transform combination_from_object;  // taken from the message
  Transform combination_from_own;     // analytic shapes: from the space in which they have size 1
  CsgBox box;
};

/// InvalidArgument where the shape is not a closed solid, has what only the combination can have, or cannot
/// be placed.
absl::StatusOr<CsgOperand> read_csg_operand(const v1::Shape& shape, const BlobSource& blobs);

/// Appends the geometry of an operand, with its own normals outward, placed for surface_at().
absl::Status add_csg_operand(const v1::Shape& shape, const Transform& placed_from_object,
                             const BlobSource& blobs, ShapeTable& table, ShapeRecord& record);

}  // namespace tessera::render
