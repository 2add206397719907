// The bytes of a triangle mesh. Little endian, every array 16-byte aligned from the start of the blob, so
// that a mapped file can be used in place:
//
//   0   char[8]  magic "TSRMESH1"
//   8   u32      flags (1: normals, 2: uvs)
//   12  u32      reserved, 0
//   16  u64      vertex count V (at most 2^31)
//   24  u64      triangle count T (at most 2^31)
//   32  f32[3V]  positions, object space
//   ..  f32[3V]  shading normals, when flagged (not necessarily of unit length)
//   ..  f32[2V]  texture coordinates, when flagged
//   ..  u32[3T]  vertex indices
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace tessera::wire {

/// Owned arrays of a mesh. `normals` and `uvs` are empty or have one entry a vertex.
struct MeshData {
  std::vector<float> positions;        // xyz xyz ...
  std::vector<float> normals;          // xyz xyz ... or empty
  std::vector<float> uvs;              // uv uv ... or empty
  std::vector<std::uint32_t> indices;  // three a triangle
};

/// The same arrays inside a blob, which must outlive the view.
struct MeshView {
  std::span<const float> positions;
  std::span<const float> normals;
  std::span<const float> uvs;
  std::span<const std::uint32_t> indices;

  std::size_t vertex_count() const { return positions.size() / 3; }
  std::size_t triangle_count() const { return indices.size() / 3; }
};

/// The blob of a mesh; the arrays must fit one another.
std::string encode_mesh(const MeshData& mesh);

/// Whether `blob` has the mark of a mesh.
bool is_mesh(std::string_view blob);

/// A view into `blob`, whose data must be 4-byte aligned. InvalidArgument, with what is wrong, for a bad
/// magic, sizes that do not fit the blob, an index out of range, or a position that is not finite.
absl::StatusOr<MeshView> decode_mesh(std::string_view blob);

}  // namespace tessera::wire
