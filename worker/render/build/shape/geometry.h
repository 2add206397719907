// The geometry of each kind of shape: a message in, the arrays of its kind and what its record says of them
// out. `placed` is render space, or the space of an object.
#pragma once

#include "absl/status/status.h"
#include "render/build/blob_source.h"
#include "render/build/placement/transform.h"
#include "render/shape/shape_table.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

// mesh.cpp
absl::Status add_mesh(const v1::Shape& shape, const Transform& placed_from_object, const BlobSource& blobs,
                      ShapeTable& table, ShapeRecord& record);
/// Placed by `transform`, low and high corner; at the origin without vertices. Errors as of add_mesh().
absl::StatusOr<std::pair<Imath::V3d, Imath::V3d>> bounds_of_mesh(const v1::TriangleMesh& mesh,
                                                                 const Transform& transform,
                                                                 const BlobSource& blobs);

// quadrics.cpp
absl::Status add_quadric(const v1::Shape& shape, const Transform& placed_from_object, ShapeTable& table,
                         ShapeRecord& record);

// sdf_grid.cpp
absl::Status add_sdf_grid(const v1::Shape& shape, const Transform& placed_from_object,
                          const BlobSource& blobs, ShapeTable& table, ShapeRecord& record);

// implicit.cpp
absl::Status add_implicit(const v1::Shape& shape, const Transform& placed_from_object, ShapeTable& table,
                          ShapeRecord& record);

// curves.cpp
absl::Status add_curves(const v1::Shape& shape, const Transform& placed_from_object, const BlobSource& blobs,
                        ShapeTable& table, ShapeRecord& record);

}  // namespace tessera::render
