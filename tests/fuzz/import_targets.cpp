#include "fuzz/import_targets.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <vector>

#include "import/import.h"
#include "import/ply/ply_reader.h"
#include "wire/mesh_blob.h"

namespace tessera::fuzz {
namespace {

/// A fuzz target has no test framework around it: a broken promise ends the process.
void require(bool promise, const char* what) {
  if (promise) return;
  std::fprintf(stderr, "%s\n", what);
  std::abort();
}

/// True when the importer accepts the file.
bool try_file(std::string_view bytes, const std::filesystem::path& path) {
  // A fresh file each time: writing over the old one makes some file systems wait for the disk.
  std::filesystem::remove(path);
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  const auto scene = client::import_scene(path, {.threads = 1, .defines = {}});
  if (!scene.ok()) {
    require(!scene.status().message().empty(), "an error without a message");
    return false;
  }
  for (const client::SceneBlob& blob : scene->blobs) {
    if (blob.file.empty()) require(wire::decode_mesh(blob.bytes).ok(), "the importer made an unsound mesh");
  }
  return true;
}

}  // namespace

void try_ply(std::string_view bytes) {
  // Nothing behind the last byte, so that address sanitizers see every step too far.
  const std::vector<char> exact(bytes.begin(), bytes.end());
  const auto ply = client::read_ply({exact.data(), exact.size()});
  if (ply.ok()) {
    require(wire::decode_mesh(wire::encode_mesh(ply->mesh)).ok(), "the PLY reader made an unsound mesh");
  } else {
    require(!ply.status().message().empty(), "an error without a message");
  }
}

void try_pbrt(std::string_view bytes, const char* folder) {
  try_file(bytes, std::filesystem::path(folder) / "fuzz.pbrt");
}

void try_text_scene(std::string_view bytes, const char* folder) {
  try_file(bytes, std::filesystem::path(folder) / "fuzz.textproto");
}

bool is_accepted(std::string_view bytes, const char* path) { return try_file(bytes, path); }

}  // namespace tessera::fuzz
