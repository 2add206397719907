#include "import/tessera_scene/write_scene.h"

#include <fstream>
#include <unordered_map>
#include <unordered_set>

#include "google/protobuf/text_format.h"
#include "import/input/concat.h"
#include "import/tessera_scene/blob_refs.h"

namespace tessera::client::tessera_scene {
namespace {

absl::Status write_file(const std::filesystem::path& path, std::string_view bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  return file ? absl::OkStatus() : absl::UnavailableError(concat(path.string(), ": cannot be written"));
}

absl::Status write_blob(const SceneBlob& blob, const std::filesystem::path& path) {
  if (blob.file.empty()) return write_file(path, blob.bytes);
  std::error_code error;
  // A blob may be written over itself when a scene is converted in place.
  if (std::filesystem::equivalent(blob.file, path, error)) return absl::OkStatus();
  std::filesystem::copy_file(blob.file, path, std::filesystem::copy_options::overwrite_existing, error);
  return error ? absl::UnavailableError(concat(path.string(), ": ", error.message())) : absl::OkStatus();
}

}  // namespace

absl::Status write_scene(const ImportedScene& scene, const std::filesystem::path& path, bool as_text) {
  const std::string folder = concat(path.stem().string(), "-blobs");
  std::error_code error;
  if (!scene.blobs.empty()) std::filesystem::create_directories(path.parent_path() / folder, error);
  if (error) return absl::UnavailableError(concat(folder, ": ", error.message()));

  std::unordered_map<std::string, const SceneBlob*> blob_of_digest;
  for (const SceneBlob& blob : scene.blobs) blob_of_digest[blob.ref.digest()] = &blob;

  v1::Scene message = scene.scene;
  std::unordered_set<std::string> written;
  absl::Status status;
  for_each_blob_ref(message, nullptr, [&](v1::BlobRef& ref, bool is_mesh, int) {
    if (!status.ok()) return;
    const auto found = blob_of_digest.find(ref.digest());
    if (found == blob_of_digest.end()) {
      status = absl::InvalidArgumentError(concat("blob ", ref.digest(), " of the scene is missing"));
      return;
    }
    // The ending tells the format of an image, as it did before.
    const std::string ending = is_mesh ? ".tsr" : std::filesystem::path(ref.path()).extension().string();
    ref.set_path(concat(folder, "/", ref.digest(), ending));
    if (written.insert(ref.path()).second)
      status = write_blob(*found->second, path.parent_path() / ref.path());
  });
  if (!status.ok()) return status;

  std::string bytes;
  const bool printed = as_text ? google::protobuf::TextFormat::PrintToString(message, &bytes)
                               : message.SerializeToString(&bytes);
  if (!printed) return absl::InternalError("the scene cannot be printed");
  return write_file(path, bytes);
}

}  // namespace tessera::client::tessera_scene
