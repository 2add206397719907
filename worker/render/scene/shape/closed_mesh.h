// Meshes as solids: whether they are closed, and the trees in which rays find their triangles.
#pragma once

#include "absl/status/statusor.h"
#include "render/scene/placement/transform.h"
#include "render/shape/csg/csg_record.h"
#include "wire/mesh_blob.h"

namespace tessera::render {

/// The mesh, placed; triangles keep their numbers. Vertices at the same place are one. InvalidArgument where
/// an edge has an odd number of triangles, with the number of such edges and the places of the first, or
/// where nothing is left.
absl::StatusOr<CsgMesh> closed_mesh(const wire::MeshView& mesh, const Transform& placed_from_object);

}  // namespace tessera::render
