// An imported scene's blobs where they lie, for a coordinator and a worker of the same process.
#pragma once

#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "absl/status/statusor.h"
#include "import/input/imported_scene.h"
#include "render/scene/load_scene.h"
#include "store/blobs/blob_store.h"

namespace tessera::client {

/// Holds these blobs, which must outlive the store, and in memory what a job's phases make. Thread-safe.
class SceneBlobs final : public server::BlobStore {
 public:
  explicit SceneBlobs(const std::vector<const SceneBlob*>& blobs);

  /// The bytes in place: in memory, or as the mapped file.
  absl::StatusOr<render::BlobBytes> bytes(const std::string& digest) const;

  server::UploadState query(const std::string& digest) const override;
  absl::StatusOr<std::unique_ptr<server::BlobWriter>> write(const std::string& digest,
                                                            std::uint64_t offset) override;
  absl::StatusOr<std::unique_ptr<server::BlobReader>> read(const std::string& digest) const override;
  absl::Status drop(const std::string& digest) override;

 private:
  std::unordered_map<std::string, const SceneBlob*> blobs_;
  const std::unique_ptr<server::BlobStore> made_ = server::make_memory_blob_store();
};

}  // namespace tessera::client
