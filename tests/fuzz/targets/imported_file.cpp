#include "fuzz/targets/imported_file.h"

#include "fuzz/target.h"
#include "import/import.h"
#include "wire/mesh_blob.h"
#include "wire/volume_blob.h"

namespace tessera::fuzz {

bool accepts_file(std::string_view bytes, const std::string& ending) {
  const auto scene =
      client::import_scene(scratch_file(ending + "." + ending, bytes), {.threads = 1, .defines = {}});
  if (!scene.ok()) {
    require(!scene.status().message().empty(), "an error without a message");
    return false;
  }
  for (const client::SceneBlob& blob : scene->blobs) {
    require(!blob.file.empty() || wire::decode_mesh(blob.bytes).ok() || wire::decode_volume(blob.bytes).ok(),
            "the importer made an unsound blob");
  }
  return true;
}

}  // namespace tessera::fuzz
