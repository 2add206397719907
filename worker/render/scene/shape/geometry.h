// The geometry of each kind of shape: a message in, the arrays of its kind and what its record says of them
// out. `placed` is render space, or the space of an object.
#pragma once

#include <span>
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
/// `later_places`: where a mesh stands at later keys, evenly spaced; empty for all that stands still, and for
/// other kinds. Throws Stopped once a stop is requested, from within a mesh too.
absl::Status add_geometry(const v1::Shape& shape, const Transform& placed_from_object, bool as_triangles,
                          const BlobSource& blobs, ShapeTable& table, ShapeRecord& record,
                          const std::stop_token& stop = {}, std::span<const Transform> later_places = {});
/// The name of a kind that an error is for where it has an area light; null for others.
const char* kind_without_light(const v1::Shape& shape);

// mesh.cpp
/// Appends a mesh of arrays in place of a blob.
absl::Status add_mesh_arrays(const v1::Shape& shape, const wire::MeshView& mesh,
                             const Transform& placed_from_object, ShapeTable& table, ShapeRecord& record,
                             const std::stop_token& stop = {});
/// closed_mesh() of a message. Errors as of add_geometry(), too.
absl::StatusOr<CsgMesh> closed_mesh_of(const v1::TriangleMesh& mesh, const Transform& transform,
                                       const BlobSource& blobs);
/// Placed by `transform`, low and high corner; at the origin without vertices. Errors as of add_geometry().
absl::StatusOr<std::pair<Imath::V3d, Imath::V3d>> bounds_of_mesh(const v1::TriangleMesh& mesh,
                                                                 const Transform& transform,
                                                                 const BlobSource& blobs);

/// The segments between the keys of a mesh, or curves, that deform: Embree's limit.
inline constexpr int kMostKeySegments = 128;

// quadrics.cpp
/// Has the parameters of `q` mapped as the shape says, after its own map.
absl::Status compose_uv_map(const v1::Shape& shape, QuadricRecord& q);

/// Planes of half-spaces end this far from their origin in the space that they are placed in, at most: Embree
/// bears coordinates up to 1.8e18.
inline constexpr double kFarthestPlane = 1e17;

// curves.cpp
/// Without the pieces that structures hold.
absl::StatusOr<CurvesRecord> read_curves(const v1::Shape& shape, const Transform& placed_from_object,
                                         const BlobSource& blobs);

}  // namespace tessera::render
