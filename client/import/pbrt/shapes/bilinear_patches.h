// Bilinear patches as triangles.
#pragma once

#include "wire/mesh_blob.h"

namespace tessera::client::pbrt {

struct BilinearTessellation {
  wire::MeshData mesh;
  bool curved = false;  // some patch does not lie in a plane
  int steps = 1;        // cells along each side of each patch
};

/// `indices` are four corners a patch: p00, p10, p01, p11. All patches of a mesh are cut alike, so that
/// neighbours meet. Without uvs a patch spans the unit square.
BilinearTessellation tessellate_patches(const wire::MeshData& corners,
                                        const std::vector<std::uint32_t>& indices);

}  // namespace tessera::client::pbrt
