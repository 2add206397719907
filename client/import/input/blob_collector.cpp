#include "import/input/blob_collector.h"

#include <fstream>
#include <utility>

#include "import/input/concat.h"
#include "wire/digest.h"

namespace tessera::client {

absl::StatusOr<v1::BlobRef> digest_file(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error))
    return absl::NotFoundError(concat(path.string(), ": no such file"));
  if (!std::filesystem::is_regular_file(path, error)) {
    return absl::InvalidArgumentError(concat(path.string(), ": not a regular file"));
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) return absl::PermissionDeniedError(concat(path.string(), ": cannot be opened"));
  wire::Sha256 hash;
  std::string buffer(std::size_t{1} << 20, '\0');
  std::uint64_t size_bytes = 0;
  while (file.read(buffer.data(), static_cast<std::streamsize>(buffer.size())) || file.gcount() > 0) {
    const std::string_view piece(buffer.data(), static_cast<std::size_t>(file.gcount()));
    hash.update(piece);
    size_bytes += piece.size();
  }
  if (file.bad()) return absl::DataLossError(concat(path.string(), ": cannot be read"));
  v1::BlobRef ref;
  ref.set_digest(hash.finish_hex());
  ref.set_size_bytes(size_bytes);
  return ref;
}

v1::BlobRef BlobCollector::add_bytes(std::string bytes, std::string digest) {
  v1::BlobRef ref;
  ref.set_digest(digest);
  ref.set_size_bytes(bytes.size());
  if (index_of_digest_.try_emplace(std::move(digest), blobs_.size()).second) {
    blobs_.push_back({ref, std::move(bytes), ""});
  }
  return ref;
}

v1::BlobRef BlobCollector::add_bytes(std::string bytes) {
  std::string digest = wire::sha256_hex(bytes);
  return add_bytes(std::move(bytes), std::move(digest));
}

absl::StatusOr<v1::BlobRef> BlobCollector::add_file(const std::filesystem::path& path,
                                                    const std::string& hint) {
  const auto known = ref_of_file_.find(path.string());
  if (known != ref_of_file_.end()) return known->second;
  absl::StatusOr<v1::BlobRef> ref = digest_file(path);
  if (!ref.ok()) return ref.status();
  ref->set_path(hint);
  if (index_of_digest_.try_emplace(ref->digest(), blobs_.size()).second) {
    blobs_.push_back({*ref, "", path.string()});
  }
  ref_of_file_.emplace(path.string(), *ref);
  return ref;
}

const SceneBlob* BlobCollector::find(const std::string& digest) const {
  const auto entry = index_of_digest_.find(digest);
  return entry == index_of_digest_.end() ? nullptr : &blobs_[entry->second];
}

}  // namespace tessera::client
