// Polygon meshes in Stanford PLY files [Turk 1994]: ascii, binary little and big endian.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "import/ply/ply_attributes.h"
#include "wire/mesh_blob.h"

namespace tessera::client {

struct PlyMesh {
  wire::MeshData mesh;
  std::vector<PlyAttribute> attributes;  // only when they are asked for
  std::vector<std::string> warnings;     // things that were approximated or not read
};

/// Reads positions (x y z), normals (nx ny nz) and texture coordinates (u v, s t, texture_u texture_v or
/// texture_s texture_t) of any scalar type and in any order, and faces (vertex_indices or vertex_index) of
/// any integer type. Polygons are cut into a fan of triangles. Other elements and properties are skipped.
///
/// InvalidArgument for bytes that are not a usable PLY file, with the line (ascii, header) or the element
/// number and byte offset (binary): truncated data, indices out of range, coordinates that are not finite,
/// counts that the file cannot hold. Memory is bounded by a small multiple of the file's size, whatever its
/// header claims.
///
/// `with_attributes`: other scalar properties of vertices and faces are read too, grouped as in
/// ply_attributes.h.
absl::StatusOr<PlyMesh> read_ply(std::string_view bytes, bool with_attributes = false);

}  // namespace tessera::client
