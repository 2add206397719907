// Smooth shading normals for meshes that have none.
#pragma once

#include "import/geometry/transform.h"
#include "wire/mesh_blob.h"

namespace tessera::client {

/// Gives every vertex the mean of its faces' normals, weighted by the angles of the faces there [Thuermer &
/// Wuethrich 1998]. Angles are those of the mesh placed by `world_from_object`, while the normals come out in
/// object space, to be placed by the inverse transpose. A vertex that no face with an area uses gets a normal
/// along x.
void compute_vertex_normals(wire::MeshData& mesh, const Imath::M44d& world_from_object);

/// Whether `t` keeps angles, so that normals computed without it are right with it.
bool keeps_angles(const Imath::M44d& t);

}  // namespace tessera::client
