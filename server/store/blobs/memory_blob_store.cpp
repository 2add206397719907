#include <mutex>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/str_cat.h"
#include "store/blobs/blob_store.h"
#include "store/blobs/upload_guard.h"
#include "wire/digest.h"

namespace tessera::server {
namespace {

/// State that the store, its writers and its readers share.
struct Contents {
  std::mutex mutex;
  absl::flat_hash_map<std::string, std::shared_ptr<const std::string>> complete;
  absl::flat_hash_map<std::string, std::string> partial;
};

class MemoryBlobWriter final : public BlobWriter {
 public:
  MemoryBlobWriter(std::unique_ptr<UploadsUnderWay::Guard> guard, std::shared_ptr<Contents> contents,
                   std::string digest, std::string begin)
      : guard_(std::move(guard)),
        contents_(std::move(contents)),
        digest_(std::move(digest)),
        bytes_(std::move(begin)) {}

  ~MemoryBlobWriter() override {
    if (finished_) return;
    const std::lock_guard lock(contents_->mutex);
    contents_->partial[digest_] = std::move(bytes_);
  }

  absl::Status append(std::string_view bytes) override {
    bytes_ += bytes;
    return absl::OkStatus();
  }

  absl::Status finish() override {
    finished_ = true;
    if (const std::string found = wire::sha256_hex(bytes_); found != digest_) {
      return absl::DataLossError(absl::StrCat("the bytes uploaded as ", digest_, " have the digest ", found));
    }
    const std::lock_guard lock(contents_->mutex);
    contents_->complete[digest_] = std::make_shared<const std::string>(std::move(bytes_));
    return absl::OkStatus();
  }

 private:
  std::unique_ptr<UploadsUnderWay::Guard> guard_;
  std::shared_ptr<Contents> contents_;
  std::string digest_;
  std::string bytes_;
  bool finished_ = false;
};

class MemoryBlobReader final : public BlobReader {
 public:
  explicit MemoryBlobReader(std::shared_ptr<const std::string> bytes) : bytes_(std::move(bytes)) {}

  std::uint64_t size() const override { return bytes_->size(); }

  absl::StatusOr<std::string> read(std::uint64_t offset, std::size_t size) const override {
    return offset >= bytes_->size() ? std::string() : bytes_->substr(offset, size);
  }

 private:
  std::shared_ptr<const std::string> bytes_;
};

class MemoryBlobStore final : public BlobStore {
 public:
  UploadState query(const std::string& digest) const override {
    const std::lock_guard lock(contents_->mutex);
    return find(digest);
  }

  absl::StatusOr<std::unique_ptr<BlobWriter>> write(const std::string& digest,
                                                    std::uint64_t offset) override {
    auto guard = uploads_->hold(digest);
    if (guard == nullptr)
      return absl::UnavailableError(absl::StrCat("blob ", digest, " is being uploaded; try again"));
    const std::lock_guard lock(contents_->mutex);
    const UploadState stored = find(digest);
    if (stored.complete) return absl::AlreadyExistsError(absl::StrCat("blob ", digest, " is complete"));
    if (offset != 0 && offset != stored.stored_bytes) {
      return absl::OutOfRangeError(
          absl::StrCat("the upload of ", digest, " goes on at ", stored.stored_bytes, ", not at ", offset));
    }
    std::string begin;
    if (const auto partial = contents_->partial.find(digest); partial != contents_->partial.end()) {
      if (offset > 0) begin = std::move(partial->second);
      contents_->partial.erase(partial);
    }
    return std::make_unique<MemoryBlobWriter>(std::move(guard), contents_, digest, std::move(begin));
  }

  absl::StatusOr<std::unique_ptr<BlobReader>> read(const std::string& digest) const override {
    const std::lock_guard lock(contents_->mutex);
    const auto found = contents_->complete.find(digest);
    if (found == contents_->complete.end())
      return absl::NotFoundError(absl::StrCat("there is no blob ", digest));
    return std::make_unique<MemoryBlobReader>(found->second);
  }

  absl::Status drop(const std::string& digest) override {
    const std::lock_guard lock(contents_->mutex);
    contents_->complete.erase(digest);
    return absl::OkStatus();
  }

 private:
  UploadState find(const std::string& digest) const {
    const auto complete = contents_->complete.find(digest);
    if (complete != contents_->complete.end()) return {complete->second->size(), true};
    const auto partial = contents_->partial.find(digest);
    return {partial == contents_->partial.end() ? 0 : partial->second.size(), false};
  }

  std::shared_ptr<Contents> contents_ = std::make_shared<Contents>();
  std::shared_ptr<UploadsUnderWay> uploads_ = std::make_shared<UploadsUnderWay>();
};

}  // namespace

std::unique_ptr<BlobStore> make_memory_blob_store() { return std::make_unique<MemoryBlobStore>(); }

}  // namespace tessera::server
