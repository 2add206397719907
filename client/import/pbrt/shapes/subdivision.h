// Loop subdivision surfaces.
#pragma once

#include <optional>

#include "wire/mesh_blob.h"

namespace tessera::client::pbrt {

/// The mesh after `levels` refinements, its vertices moved to the limit surface, with the limit's normals
/// [Loop 1987; Hoppe et al. 1994; rules at borders as in pbrt-v4]. The normals turn the way that pbrt-v4's
/// do: against those of the faces. Nothing where an edge has more than two faces, or two that run along it
/// the same way.
std::optional<wire::MeshData> subdivide_loop(const wire::MeshData& control, int levels);

}  // namespace tessera::client::pbrt
