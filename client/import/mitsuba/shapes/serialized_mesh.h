// Mitsuba's .serialized files: meshes, each in a zlib stream of its own.
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "wire/mesh_blob.h"

namespace tessera::client::mitsuba {

struct SerializedMesh {
  wire::MeshData mesh;
  bool face_normals = false;  // the file asks for a faceted look
};

/// Mesh `index` of a file of format version 3 or 4, with float or double values. Vertex colours are skipped.
/// InvalidArgument for anything else, and for damaged data.
absl::StatusOr<SerializedMesh> read_serialized_mesh(std::string_view bytes, std::int64_t index);

}  // namespace tessera::client::mitsuba
