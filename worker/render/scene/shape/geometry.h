// The geometry of each kind of shape: a message in, the arrays of its kind and what its record says of them
// out. `placed` is render space, or the space of an object.
#pragma once

#include <stop_token>

#include "absl/status/status.h"
#include "render/scene/blob_source.h"
#include "render/scene/placement/transform.h"
#include "render/shape/shape_table.h"
#include "tessera/v1/scene.pb.h"
#include "wire/mesh_blob.h"

namespace tessera::render {

// add_geometry.cpp
/// A shape of any kind but combinations. `as_triangles`: flat shapes as the triangles that they consist of.
/// Throws Stopped once a stop is requested, from within a mesh too.
absl::Status add_geometry(const v1::Shape& shape, const Transform& placed_from_object, bool as_triangles,
                          const BlobSource& blobs, ShapeTable& table, ShapeRecord& record,
                          const std::stop_token& stop = {});
/// The name of a kind that an error is for where it has an area light; null for others.
const char* kind_without_light(const v1::Shape& shape);

// mesh.cpp
absl::Status add_mesh(const v1::Shape& shape, const Transform& placed_from_object, const BlobSource& blobs,
                      ShapeTable& table, ShapeRecord& record, const std::stop_token& stop = {});
/// A mesh of arrays in place of a blob.
absl::Status add_mesh_arrays(const v1::Shape& shape, const wire::MeshView& mesh,
                             const Transform& placed_from_object, ShapeTable& table, ShapeRecord& record,
                             const std::stop_token& stop = {});
/// closed_mesh() of a message. Errors as of add_mesh(), too.
absl::StatusOr<CsgMesh> closed_mesh_of(const v1::TriangleMesh& mesh, const Transform& transform,
                                       const BlobSource& blobs);
/// Placed by `transform`, low and high corner; at the origin without vertices. Errors as of add_mesh().
absl::StatusOr<std::pair<Imath::V3d, Imath::V3d>> bounds_of_mesh(const v1::TriangleMesh& mesh,
                                                                 const Transform& transform,
                                                                 const BlobSource& blobs);

// quadrics.cpp
absl::Status add_quadric(const v1::Shape& shape, const Transform& placed_from_object, ShapeTable& table,
                         ShapeRecord& record, Transform* exact = nullptr);
/// Has the parameters of `q` mapped as the shape says, after its own map.
absl::Status compose_uv_map(const v1::Shape& shape, QuadricRecord& q);
/// Appends `q` where a shape is whose object space is placed so, with its parameters mapped and its normal
/// turned as the shape says.
/// `exact`, if wanted, is where it was placed, in double precision.
absl::Status place_quadric(const v1::Shape& shape, const Transform& placed_from_object, QuadricRecord q,
                           ShapeTable& table, ShapeRecord& record, Transform* exact = nullptr);

/// Planes of half-spaces end this far from their origin in the space that they are placed in, at most: Embree
/// bears coordinates up to 1.8e18.
inline constexpr double kFarthestPlane = 1e17;

// round_solids.cpp: half-spaces, cones, cylinders with caps, tori, ellipsoids
absl::Status add_round_solid(const v1::Shape& shape, const Transform& placed_from_object, ShapeTable& table,
                             ShapeRecord& record, Transform* exact = nullptr);

// flat_shapes.cpp: polygons, boxes, convex polyhedra; `as_mesh`: as the triangles that they consist of
absl::Status add_flat_shape(const v1::Shape& shape, const Transform& placed_from_object, bool as_mesh,
                            ShapeTable& table, ShapeRecord& record, Transform* exact = nullptr);

// sdf_grid.cpp
absl::Status add_sdf_grid(const v1::Shape& shape, const Transform& placed_from_object,
                          const BlobSource& blobs, ShapeTable& table, ShapeRecord& record);

// implicit.cpp
absl::Status add_implicit(const v1::Shape& shape, const Transform& placed_from_object, ShapeTable& table,
                          ShapeRecord& record);

// curves.cpp
/// Without the pieces that structures hold.
absl::StatusOr<CurvesRecord> read_curves(const v1::Shape& shape, const Transform& placed_from_object,
                                         const BlobSource& blobs);
absl::Status add_curves(const v1::Shape& shape, const Transform& placed_from_object, const BlobSource& blobs,
                        ShapeTable& table, ShapeRecord& record);

}  // namespace tessera::render
