#include "local/scene_blobs.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "agent/stores/mapped_file.h"

namespace tessera::client {
namespace {

class InPlaceReader final : public server::BlobReader {
 public:
  explicit InPlaceReader(render::BlobBytes bytes) : bytes_(std::move(bytes)) {}

  std::uint64_t size() const override { return bytes_.bytes.size(); }
  absl::StatusOr<std::string> read(std::uint64_t offset, std::size_t size) const override {
    if (offset >= bytes_.bytes.size()) return std::string{};
    return std::string{bytes_.bytes.substr(offset, size)};
  }

 private:
  render::BlobBytes bytes_;
};

}  // namespace

SceneBlobs::SceneBlobs(const std::vector<const SceneBlob*>& blobs) {
  for (const SceneBlob* blob : blobs) blobs_.emplace(blob->ref.digest(), blob);
}

absl::StatusOr<render::BlobBytes> SceneBlobs::bytes(const std::string& digest) const {
  const auto found = blobs_.find(digest);
  if (found == blobs_.end()) return absl::NotFoundError(absl::StrCat("the scene has no blob ", digest));
  const SceneBlob& blob = *found->second;
  if (blob.file.empty() && blob.bytes.size() != blob.ref.size_bytes()) {
    return absl::FailedPreconditionError(
        absl::StrCat("the bytes of ", digest, " were freed after the first use"));
  }
  if (blob.file.empty()) return render::BlobBytes{blob.bytes, nullptr};
  absl::StatusOr<render::BlobBytes> mapped = agent::map_file(blob.file);
  if (mapped.ok() && mapped->bytes.size() != blob.ref.size_bytes()) {
    return absl::DataLossError(absl::StrCat(blob.file, ": changed while it was in use"));
  }
  return mapped;
}

server::UploadState SceneBlobs::query(const std::string& digest) const {
  const auto found = blobs_.find(digest);
  if (found == blobs_.end()) return made_->query(digest);
  return {found->second->ref.size_bytes(), true};
}

absl::StatusOr<std::unique_ptr<server::BlobWriter>> SceneBlobs::write(const std::string& digest,
                                                                      std::uint64_t offset) {
  if (blobs_.contains(digest))
    return absl::AlreadyExistsError(absl::StrCat("blob ", digest, " is the scene's own"));
  return made_->write(digest, offset);
}

absl::Status SceneBlobs::drop(const std::string& digest) {
  if (!blobs_.contains(digest)) return made_->drop(digest);
  return absl::FailedPreconditionError(absl::StrCat("blob ", digest, " is the scene's own"));
}

absl::StatusOr<std::unique_ptr<server::BlobReader>> SceneBlobs::read(const std::string& digest) const {
  if (!blobs_.contains(digest)) return made_->read(digest);
  absl::StatusOr<render::BlobBytes> found = bytes(digest);
  if (!found.ok()) return found.status();
  return std::make_unique<InPlaceReader>(*std::move(found));
}

}  // namespace tessera::client
