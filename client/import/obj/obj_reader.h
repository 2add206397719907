// Polygon meshes in Wavefront OBJ files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "wire/mesh_blob.h"

namespace tessera::client {

struct ObjMesh {
  wire::MeshData mesh;
  std::vector<std::string> warnings;  // things that were approximated or not read
};

/// Reads v, vt, vn and f; groups, objects and materials all become one mesh, other lines are skipped.
/// Polygons are cut into a fan of triangles. Indices may be negative (counted from the end so far). Corners
/// with the same indices become one vertex. Where only some corners have a texture coordinate, the others get
/// (0, 0); normals are kept only when all corners have one.
///
/// InvalidArgument with "line N: ..." for what cannot be read: a number that is none, an index out of range,
/// a coordinate that is not finite.
absl::StatusOr<ObjMesh> read_obj(std::string_view bytes);

}  // namespace tessera::client
