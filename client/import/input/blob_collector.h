// Gathers the blobs of a scene, each digest once.
#pragma once

#include <filesystem>
#include <string>
#include <unordered_map>
#include <vector>

#include "absl/status/statusor.h"
#include "import/input/imported_scene.h"

namespace tessera::client {

/// SHA-256 and size of a file, read in pieces: nothing larger than a buffer is held.
absl::StatusOr<v1::BlobRef> digest_file(const std::filesystem::path& path);

class BlobCollector {
 public:
  /// Takes bytes whose digest is known. Bytes already present are dropped.
  v1::BlobRef add_bytes(std::string bytes, std::string digest);
  v1::BlobRef add_bytes(std::string bytes);

  /// Takes a file by reference. `hint` becomes BlobRef.path. The file is digested once however often it is
  /// named.
  absl::StatusOr<v1::BlobRef> add_file(const std::filesystem::path& path, const std::string& hint);

  /// The blob of a digest, or null.
  const SceneBlob* find(const std::string& digest) const;

  std::vector<SceneBlob> take() { return std::move(blobs_); }

 private:
  std::vector<SceneBlob> blobs_;
  std::unordered_map<std::string, std::size_t> index_of_digest_;
  std::unordered_map<std::string, v1::BlobRef> ref_of_file_;
};

}  // namespace tessera::client
