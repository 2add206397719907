// Surfaces of the scene's shapes, as receivers.
#pragma once

#include "absl/status/statusor.h"
#include "import/input/imported_scene.h"
#include "measure/receivers.h"

namespace tessera::client {

/// The surface of a shape of the scene, one cell: meshes, convex polygons, boxes, and whole spheres and
/// disks, also where an ellipsoid or a transform makes them. InvalidArgument for all others, with the reason.
absl::StatusOr<ReceiverPlace> surface_of(const v1::Shape& shape, const ImportedScene& scene, bool inside);

/// The same surface with a cell for each triangle. InvalidArgument where it has none, ResourceExhausted with
/// the memory that figures of so many would take.
absl::StatusOr<ReceiverPlace> triangles_of(const v1::Shape& shape, const ImportedScene& scene, bool inside);

}  // namespace tessera::client
