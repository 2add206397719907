// Combinations of solids (CSG): from a message to the arrays of shape/csg/csg_record.h.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "render/scene/blob_source.h"
#include "render/scene/placement/transform.h"
#include "render/scene/shape/csg_tree.h"
#include "render/shape/shape_table.h"

namespace tessera::render {

/// Adds a combination and appends the records of its solids to `solids`; the caller gives them materials and
/// media, and a place in ShapeTable::shapes which CsgSolid::shape has to name. False where it is empty.
/// InvalidArgument names the operand that is not a closed solid or cannot be placed.
absl::StatusOr<bool> add_csg(const v1::Shape& shape, const CsgTree& tree, const Transform& placed_from_object,
                             const BlobSource& blobs, ShapeTable& table, ShapeRecord& record,
                             std::vector<ShapeRecord>& solids);

/// So many solids at one place that a ray there takes more than a millisecond.
inline constexpr std::size_t kCrowd = 4096;
/// Whether the boxes of so many solids have a place in common.
bool is_crowded(const CsgRecord& csg);

}  // namespace tessera::render
