#include "wire/mesh_blob.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>

#include "absl/strings/str_cat.h"

namespace tessera::wire {
namespace {

static_assert(std::endian::native == std::endian::little, "blobs are used in place");

constexpr char kMagic[] = "TSRMESH1";
constexpr std::uint32_t kHasNormals = 1;
constexpr std::uint32_t kHasUvs = 2;
constexpr std::size_t kHeaderBytes = 32;
constexpr std::uint64_t kMaxElements = std::uint64_t{1} << 31;

std::size_t align16(std::size_t bytes) { return (bytes + 15) & ~std::size_t{15}; }

/// Where each array begins. All sizes are far below 2^64 for counts of at most 2^31.
struct Layout {
  std::size_t positions = kHeaderBytes;
  std::size_t normals, uvs, indices, total;

  Layout(std::size_t vertices, std::size_t triangles, std::uint32_t flags) {
    normals = align16(positions + 12 * vertices);
    uvs = flags & kHasNormals ? align16(normals + 12 * vertices) : normals;
    indices = flags & kHasUvs ? align16(uvs + 8 * vertices) : uvs;
    total = indices + 12 * triangles;
  }
};

template <typename T>
void put(std::string& blob, std::size_t offset, const std::vector<T>& array) {
  if (!array.empty()) std::memcpy(blob.data() + offset, array.data(), array.size() * sizeof(T));
}

template <typename T>
std::span<const T> view(std::string_view blob, std::size_t offset, std::size_t count) {
  return {reinterpret_cast<const T*>(blob.data() + offset), count};
}

absl::Status unsound(const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat("mesh blob: ", what));
}

absl::Status check_contents(const MeshView& mesh) {
  // One pass without branches first: only a bad mesh is searched for the culprit.
  float infinity_probe = 0.0f;
  for (const float x : mesh.positions) infinity_probe += x * 0.0f;
  if (!std::isfinite(infinity_probe)) {
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      if (!std::isfinite(mesh.positions[i]))
        return unsound(absl::StrCat("position of vertex ", i / 3, " is not finite"));
    }
  }
  std::uint32_t largest = 0;
  for (const std::uint32_t index : mesh.indices) largest = std::max(largest, index);
  if (!mesh.indices.empty() && largest >= mesh.vertex_count()) {
    return unsound(absl::StrCat("vertex index ", largest, " is out of range: there are ", mesh.vertex_count(),
                                " vertices"));
  }
  return absl::OkStatus();
}

}  // namespace

std::string encode_mesh(const MeshData& mesh) {
  const std::uint64_t vertices = mesh.positions.size() / 3;
  const std::uint64_t triangles = mesh.indices.size() / 3;
  assert(mesh.positions.size() == 3 * vertices && mesh.indices.size() == 3 * triangles);
  assert(mesh.normals.empty() || mesh.normals.size() == 3 * vertices);
  assert(mesh.uvs.empty() || mesh.uvs.size() == 2 * vertices);
  const std::uint32_t flags = (mesh.normals.empty() ? 0 : kHasNormals) | (mesh.uvs.empty() ? 0 : kHasUvs);
  const Layout layout(vertices, triangles, flags);

  std::string blob(layout.total, '\0');
  std::memcpy(blob.data(), kMagic, 8);
  std::memcpy(blob.data() + 8, &flags, 4);
  std::memcpy(blob.data() + 16, &vertices, 8);
  std::memcpy(blob.data() + 24, &triangles, 8);
  put(blob, layout.positions, mesh.positions);
  put(blob, layout.normals, mesh.normals);
  put(blob, layout.uvs, mesh.uvs);
  put(blob, layout.indices, mesh.indices);
  return blob;
}

bool is_mesh(std::string_view blob) { return blob.starts_with(std::string_view(kMagic, 8)); }

absl::StatusOr<MeshView> decode_mesh(std::string_view blob) {
  if (reinterpret_cast<std::uintptr_t>(blob.data()) % 4 != 0)
    return unsound("the bytes are not 4-byte aligned");
  if (blob.size() < kHeaderBytes)
    return unsound(absl::StrCat(blob.size(), " bytes are too few for the header"));
  if (std::memcmp(blob.data(), kMagic, 8) != 0) return unsound("bad magic number");
  std::uint32_t flags, reserved;
  std::uint64_t vertices, triangles;
  std::memcpy(&flags, blob.data() + 8, 4);
  std::memcpy(&reserved, blob.data() + 12, 4);
  std::memcpy(&vertices, blob.data() + 16, 8);
  std::memcpy(&triangles, blob.data() + 24, 8);
  if ((flags & ~(kHasNormals | kHasUvs)) != 0 || reserved != 0)
    return unsound(absl::StrCat("unknown flags ", flags));
  if (vertices > kMaxElements || triangles > kMaxElements) {
    return unsound(absl::StrCat(vertices, " vertices and ", triangles, " triangles are more than 2^31"));
  }
  const Layout layout(vertices, triangles, flags);
  if (layout.total != blob.size()) {
    return unsound(absl::StrCat(vertices, " vertices and ", triangles, " triangles take ", layout.total,
                                " bytes, but there are ", blob.size()));
  }

  MeshView mesh;
  mesh.positions = view<float>(blob, layout.positions, 3 * vertices);
  if (flags & kHasNormals) mesh.normals = view<float>(blob, layout.normals, 3 * vertices);
  if (flags & kHasUvs) mesh.uvs = view<float>(blob, layout.uvs, 2 * vertices);
  mesh.indices = view<std::uint32_t>(blob, layout.indices, 3 * triangles);
  if (absl::Status status = check_contents(mesh); !status.ok()) return status;
  return mesh;
}

}  // namespace tessera::wire
