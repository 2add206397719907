#include "fuzz/import_targets.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <vector>

#include "import/import.h"
#include "import/mitsuba/serialized_mesh.h"
#include "import/mitsuba/volume_file.h"
#include "import/obj/obj_reader.h"
#include "import/ply/ply_reader.h"
#include "wire/mesh_blob.h"
#include "wire/volume_blob.h"

namespace tessera::fuzz {
namespace {

/// A fuzz target has no test framework around it: a broken promise ends the process.
void require(bool promise, const char* what) {
  if (promise) return;
  std::fprintf(stderr, "%s\n", what);
  std::abort();
}

/// What a reader of meshes gives is sound, or an error with a message.
template <typename Result>
void require_sound_mesh(const Result& result) {
  if (result.ok()) {
    require(wire::decode_mesh(wire::encode_mesh(result->mesh)).ok(), "a reader made an unsound mesh");
  } else {
    require(!result.status().message().empty(), "an error without a message");
  }
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
  for (const bool with_attributes : {false, true}) {
    const auto ply = client::read_ply({exact.data(), exact.size()}, with_attributes);
    require_sound_mesh(ply);
    if (!ply.ok()) continue;
    for (const client::PlyAttribute& attribute : ply->attributes) {
      const std::size_t elements =
          attribute.per_face ? ply->mesh.indices.size() / 3 : ply->mesh.positions.size() / 3;
      require(attribute.values.size() == elements * attribute.channels, "the PLY reader made an unsound attribute");
    }
  }
}

void try_obj(std::string_view bytes) {
  const std::vector<char> exact(bytes.begin(), bytes.end());
  require_sound_mesh(client::read_obj({exact.data(), exact.size()}));
}

void try_serialized(std::string_view bytes) {
  const std::vector<char> exact(bytes.begin(), bytes.end());
  for (const std::int64_t index : {0, 1}) {
    require_sound_mesh(client::mitsuba::read_serialized_mesh({exact.data(), exact.size()}, index));
  }
}

void try_volume(std::string_view bytes) {
  const std::vector<char> exact(bytes.begin(), bytes.end());
  const auto volume = client::mitsuba::read_volume_file({exact.data(), exact.size()});
  if (volume.ok()) {
    require(wire::decode_volume(volume->blob).ok(), "the volume reader made an unsound volume");
  } else {
    require(!volume.status().message().empty(), "an error without a message");
  }
}

void try_pbrt(std::string_view bytes, const char* folder) {
  try_file(bytes, std::filesystem::path(folder) / "fuzz.pbrt");
}

void try_mitsuba(std::string_view bytes, const char* folder) {
  try_file(bytes, std::filesystem::path(folder) / "fuzz.xml");
}

void try_text_scene(std::string_view bytes, const char* folder) {
  try_file(bytes, std::filesystem::path(folder) / "fuzz.textproto");
}

bool is_accepted(std::string_view bytes, const char* path) { return try_file(bytes, path); }

}  // namespace tessera::fuzz
