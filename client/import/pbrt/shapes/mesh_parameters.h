// Meshes whose vertices stand in the scene file.
#pragma once

#include <optional>

#include "import/pbrt/matter/textures.h"
#include "import/pbrt/shapes/bilinear_patches.h"
#include "wire/mesh_blob.h"

namespace tessera::client::pbrt {

/// P, indices, N, uv of a trianglemesh. Nothing after an error: counts that do not fit, an index out of
/// range.
std::optional<wire::MeshData> read_triangle_mesh(ValueReader& values);

/// The patches of a bilinearmesh as triangles: two for each parallelogram; for others so many that their
/// surface and their (u, v) are met closely, with shading normals where patches are curved. Says so then.
std::optional<BilinearTessellation> read_bilinear_mesh(ValueReader& values);

/// The vertices of a loopsubdiv's control mesh on its limit surface.
std::optional<wire::MeshData> read_subdivision_mesh(ValueReader& values);

/// The floats of a parameter; empty where it is absent. Errors for values beyond the range of a float.
std::vector<float> read_array(ValueReader& values, std::string_view name,
                              std::initializer_list<ParameterType> types);

}  // namespace tessera::client::pbrt
