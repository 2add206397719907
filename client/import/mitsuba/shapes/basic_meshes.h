// Meshes that need no file, as Mitsuba defines them.
#pragma once

#include "wire/mesh_blob.h"

namespace tessera::client::mitsuba {

/// [-1, 1] x [-1, 1] in the plane z = 0, normal +z, uv from (0, 0) at (-1, -1).
wire::MeshData rectangle_mesh();

/// [-1, 1]^3, normals outward, uv [0, 1]^2 on every face.
wire::MeshData cube_mesh();

}  // namespace tessera::client::mitsuba
