// Meshes with light at their vertices, as files: PLY and glTF.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace tessera::client {

struct LitMesh {
  std::vector<std::array<float, 3>> positions;
  std::vector<std::array<float, 3>> radiosity;  // radiosity of each vertex, R, G, B, W/m^2
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// The bytes of a PLY file (binary, little-endian): vertices with `x y z` and `red green blue`, which are
/// radiosities in W/m^2, all floats; faces with `vertex_indices`.
std::string to_ply(const LitMesh& mesh);

/// InvalidArgument where a mesh of so many vertices and triangles is no glTF file: the format has no empty
/// meshes, and counts the bytes of a file in 32 bits.
absl::Status check_glb_size(std::uint64_t vertices, std::uint64_t triangles);

/// The bytes of a glTF 2.0 file (binary). COLOR_0 are floats as the format wants them, linear and clamped to
/// [0, 1]: radiosity over pi, the radiance that a picture of exposure 1 shows. _RADIOSITY has it in W/m^2,
/// unclamped. Errors are those of check_glb_size.
absl::StatusOr<std::string> to_glb(const LitMesh& mesh);

/// The bytes of the format that the extension of `path` names, in capitals or not. InvalidArgument where it
/// is neither .ply nor .glb, or to_glb has it.
absl::StatusOr<std::string> mesh_bytes(const LitMesh& mesh, const std::string& path);

/// The same error, before there is a mesh.
absl::Status check_mesh_path(const std::string& path);

}  // namespace tessera::client
