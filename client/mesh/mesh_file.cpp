#include "mesh/mesh_file.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <filesystem>
#include <limits>
#include <numbers>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "nlohmann/json.hpp"

namespace tessera::client {
namespace {

static_assert(std::endian::native == std::endian::little, "both formats are little-endian");

template <class T>
void put(const T& value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}
template <class T>
void put_all(const std::vector<T>& values, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

std::string extension_of(const std::string& path) {
  return absl::AsciiStrToLower(std::filesystem::path(path).extension().string());
}

/// A chunk of a binary glTF file, filled up to a multiple of four bytes.
void put_chunk(std::uint32_t kind, std::string bytes, char filler, std::string& file) {
  bytes.resize((bytes.size() + 3) / 4 * 4, filler);
  put(static_cast<std::uint32_t>(bytes.size()), file);
  put(kind, file);
  file += bytes;
}

}  // namespace

std::string to_ply(const LitMesh& mesh) {
  std::string bytes = absl::StrCat(
      "ply\nformat binary_little_endian 1.0\ncomment red, green and blue are radiosities in W/m^2\n"
      "element vertex ",
      mesh.positions.size(),
      "\nproperty float x\nproperty float y\nproperty float z\n"
      "property float red\nproperty float green\nproperty float blue\nelement face ",
      mesh.triangles.size(), "\nproperty list uchar int vertex_indices\nend_header\n");
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    put(mesh.positions[i], bytes);
    put(mesh.radiosity[i], bytes);
  }
  for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles) {
    put(std::uint8_t{3}, bytes);
    put(triangle, bytes);
  }
  return bytes;
}

absl::Status check_glb_size(std::uint64_t vertices, std::uint64_t triangles) {
  if (vertices == 0 || triangles == 0)
    return absl::InvalidArgumentError("the mesh has no triangles, and glTF has no empty meshes: .ply has");
  // A position and two colours for each vertex; the rest describes these arrays.
  constexpr std::uint64_t kPerVertex = 36, kPerTriangle = 12, kDescription = 4096;
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max() - kDescription;
  const bool fits = vertices <= kMost / kPerVertex && triangles <= kMost / kPerTriangle &&
                    vertices * kPerVertex + triangles * kPerTriangle <= kMost;
  if (fits) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("the mesh has ", vertices, " vertices and ", triangles,
                   " triangles, and glTF counts a file's bytes in 32 bits: .ply has room for them"));
}

absl::StatusOr<std::string> to_glb(const LitMesh& mesh) {
  if (auto status = check_glb_size(mesh.positions.size(), mesh.triangles.size()); !status.ok()) return status;
  std::vector<std::array<float, 3>> colours = mesh.radiosity;
  for (std::array<float, 3>& colour : colours) {
    for (float& value : colour) value = std::clamp(value / std::numbers::pi_v<float>, 0.0f, 1.0f);
  }
  constexpr float kHuge = std::numeric_limits<float>::max();
  std::array<float, 3> low = {kHuge, kHuge, kHuge}, high = {-kHuge, -kHuge, -kHuge};
  for (const std::array<float, 3>& position : mesh.positions) {
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], position[i]);
      high[i] = std::max(high[i], position[i]);
    }
  }
  std::string data;
  nlohmann::json views = nlohmann::json::array(), accessors = nlohmann::json::array();
  constexpr int kFloat = 5126, kUint = 5125, kVertices = 34962, kIndices = 34963;
  const auto add = [&](const auto& values, int target, int type, const char* shape, std::size_t count) {
    const std::size_t first = data.size();
    put_all(values, data);
    accessors.push_back(
        {{"bufferView", views.size()}, {"componentType", type}, {"count", count}, {"type", shape}});
    views.push_back(
        {{"buffer", 0}, {"byteOffset", first}, {"byteLength", data.size() - first}, {"target", target}});
  };
  add(mesh.positions, kVertices, kFloat, "VEC3", mesh.positions.size());
  accessors.back()["min"] = low;
  accessors.back()["max"] = high;
  add(colours, kVertices, kFloat, "VEC3", colours.size());
  add(mesh.radiosity, kVertices, kFloat, "VEC3", mesh.radiosity.size());
  add(mesh.triangles, kIndices, kUint, "SCALAR", 3 * mesh.triangles.size());

  const nlohmann::json primitive = {
      {"attributes", {{"POSITION", 0}, {"COLOR_0", 1}, {"_RADIOSITY", 2}}}, {"indices", 3}, {"material", 0}};
  const nlohmann::json document = {
      {"asset", {{"version", "2.0"}, {"generator", "Tessera"}}},
      {"extensionsUsed", {"KHR_materials_unlit"}},
      {"scene", 0},
      {"scenes", {{{"nodes", {0}}}}},
      {"nodes", {{{"mesh", 0}, {"name", "radiosity"}}}},
      {"meshes", {{{"primitives", {primitive}}}}},
      {"materials", {{{"name", "lit"}, {"extensions", {{"KHR_materials_unlit", nlohmann::json::object()}}}}}},
      {"buffers", {{{"byteLength", data.size()}}}},
      {"bufferViews", views},
      {"accessors", accessors}};
  std::string chunks;
  put_chunk(0x4E4F534A, document.dump(), ' ', chunks);
  put_chunk(0x004E4942, std::move(data), '\0', chunks);
  std::string file = "glTF";
  put(std::uint32_t{2}, file);
  put(static_cast<std::uint32_t>(chunks.size() + 12), file);
  return file + chunks;
}

absl::Status check_mesh_path(const std::string& path) {
  const std::string extension = extension_of(path);
  if (extension == ".ply" || extension == ".glb") return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(path, ": .ply or .glb was expected"));
}

absl::StatusOr<std::string> mesh_bytes(const LitMesh& mesh, const std::string& path) {
  if (auto status = check_mesh_path(path); !status.ok()) return status;
  if (extension_of(path) == ".ply") return to_ply(mesh);
  return to_glb(mesh);
}

}  // namespace tessera::client
