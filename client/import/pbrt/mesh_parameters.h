// Meshes whose vertices stand in the scene file.
#pragma once

#include <optional>

#include "import/pbrt/textures.h"
#include "wire/mesh_blob.h"

namespace tessera::client::pbrt {

/// P, indices, N, uv of a trianglemesh. Nothing after an error: counts that do not fit, an index out of range.
std::optional<wire::MeshData> read_triangle_mesh(ValueReader& values);

/// The patches of a bilinearmesh, each as two triangles; warns where a patch is not flat.
std::optional<wire::MeshData> read_bilinear_mesh(ValueReader& values);

}  // namespace tessera::client::pbrt
