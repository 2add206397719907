#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <mutex>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "store/blobs/blob_store.h"
#include "store/blobs/upload_guard.h"
#include "store/file.h"
#include "wire/digest.h"

namespace tessera::server {
namespace {

constexpr std::size_t kHashChunkBytes = std::size_t{1} << 20;
// Different blobs that are read at a time: descriptors are few, and readers of one blob share its.
constexpr std::size_t kMostOpenBlobs = 128;

double gigabytes(std::uint64_t bytes) { return 1e-9 * static_cast<double>(bytes); }

/// Its file is open while something is written only: uploads may wait for long, in any number.
class FileBlobWriter final : public BlobWriter {
 public:
  FileBlobWriter(std::unique_ptr<UploadsUnderWay::Guard> guard, std::string digest,
                 std::filesystem::path partial, std::filesystem::path complete)
      : guard_(std::move(guard)),
        digest_(std::move(digest)),
        partial_(std::move(partial)),
        complete_(std::move(complete)) {}

  /// Goes on behind the first `size` bytes: hashes them.
  absl::Status resume(std::uint64_t size) {
    absl::StatusOr<File> file = File::open_or_create(partial_);
    if (!file.ok()) return file.status();
    std::string chunk;
    while (size_ < size) {
      chunk.resize(std::min<std::uint64_t>(kHashChunkBytes, size - size_));
      if (absl::Status status = file->read_at(size_, chunk.data(), chunk.size()); !status.ok()) return status;
      sha_.update(chunk);
      size_ += chunk.size();
    }
    return file->truncate(size);
  }

  absl::Status append(std::string_view bytes) override {
    absl::StatusOr<File> file = File::open_or_create(partial_);
    if (!file.ok()) return file.status();
    if (absl::Status status = file->write_at(size_, bytes); !status.ok()) return status;
    sha_.update(bytes);
    size_ += bytes.size();
    return absl::OkStatus();
  }

  absl::Status finish() override {
    absl::StatusOr<File> file = File::open_or_create(partial_);
    if (!file.ok()) return file.status();
    if (const std::string found = sha_.finish_hex(); found != digest_) {
      size_ = 0;
      if (absl::Status status = file->truncate(0); !status.ok()) return status;
      return absl::DataLossError(absl::StrCat("the bytes uploaded as ", digest_, " have the digest ", found));
    }
    // The contents first, then the name: whatever has the final name is whole.
    if (absl::Status status = file->sync(); !status.ok()) return status;
    if (absl::Status status = make_directory(complete_.parent_path()); !status.ok()) return status;
    if (absl::Status status = rename_file(partial_, complete_); !status.ok()) return status;
    if (absl::Status status = sync_directory(complete_.parent_path()); !status.ok()) return status;
    return sync_directory(complete_.parent_path().parent_path());
  }

 private:
  std::unique_ptr<UploadsUnderWay::Guard> guard_;
  std::string digest_;
  std::filesystem::path partial_, complete_;
  wire::Sha256 sha_;
  std::uint64_t size_ = 0;
};

/// A blob that somebody reads.
struct OpenBlob {
  File file;
  std::uint64_t size = 0;
};

class FileBlobReader final : public BlobReader {
 public:
  explicit FileBlobReader(std::shared_ptr<const OpenBlob> blob) : blob_(std::move(blob)) {}

  std::uint64_t size() const override { return blob_->size; }

  absl::StatusOr<std::string> read(std::uint64_t offset, std::size_t size) const override {
    std::string bytes(offset >= blob_->size ? 0 : std::min<std::uint64_t>(size, blob_->size - offset), '\0');
    if (absl::Status status = blob_->file.read_at(offset, bytes.data(), bytes.size()); !status.ok())
      return status;
    return bytes;
  }

 private:
  std::shared_ptr<const OpenBlob> blob_;
};

class FileBlobStore final : public BlobStore {
 public:
  FileBlobStore(std::filesystem::path data_dir, DiskReserve reserve)
      : data_dir_(std::move(data_dir)), reserve_(std::move(reserve)) {}

  UploadState query(const std::string& digest) const override {
    // Together with the mark, so that what was just said to be there is not collected.
    const std::lock_guard lock(collecting_);
    std::error_code error;
    const std::filesystem::path path = complete_path(digest);
    if (const auto size = std::filesystem::file_size(path, error); !error) {
      ::utimensat(AT_FDCWD, path.c_str(), nullptr,
                  0);  // used now; a disk that cannot say so is one that is not collected from
      return {size, true};
    }
    const auto size = std::filesystem::file_size(partial_path(digest), error);
    return {error ? 0 : size, false};
  }

  absl::Status check_room(std::uint64_t bytes) const override {
    if (reserve_.bytes == std::uint64_t{0}) return absl::OkStatus();
    const absl::StatusOr<DiskSpace> space = reserve_.space(data_dir_);
    if (!space.ok()) return space.status();
    const std::uint64_t kept =
        reserve_.bytes.value_or(std::min(space->total_bytes / 20, DiskReserve::kMostBytes));
    if (space->free_bytes < kept || space->free_bytes - kept < bytes) {
      return absl::ResourceExhaustedError(absl::StrFormat(
          "the coordinator's disk has %.3f GB left and keeps %.3f GB for results (tessera-server "
          "--keep-free): there is "
          "no room for %.3f GB; try again when old jobs are deleted",
          gigabytes(space->free_bytes), gigabytes(kept), gigabytes(bytes)));
    }
    if (space->free_files < std::min(space->total_files / 20, DiskReserve::kMostFiles)) {
      return absl::ResourceExhaustedError(
          absl::StrCat("the coordinator's disk has room for no more than ", space->free_files,
                       " files, which it keeps for results; try again when old jobs are deleted"));
    }
    return absl::OkStatus();
  }

  absl::StatusOr<std::unique_ptr<BlobWriter>> write(const std::string& digest,
                                                    std::uint64_t offset) override {
    auto guard = uploads_->hold(digest);
    if (guard == nullptr)
      return absl::UnavailableError(absl::StrCat("blob ", digest, " is being uploaded; try again"));
    const UploadState stored = query(digest);
    if (stored.complete) return absl::AlreadyExistsError(absl::StrCat("blob ", digest, " is complete"));
    if (offset != 0 && offset != stored.stored_bytes) {
      return absl::OutOfRangeError(
          absl::StrCat("the upload of ", digest, " goes on at ", stored.stored_bytes, ", not at ", offset));
    }
    auto writer = std::make_unique<FileBlobWriter>(std::move(guard), digest, partial_path(digest),
                                                   complete_path(digest));
    if (absl::Status status = writer->resume(offset); !status.ok()) return status;
    return writer;
  }

  absl::StatusOr<std::unique_ptr<BlobReader>> read(const std::string& digest) const override {
    const std::lock_guard lock(opening_);
    if (const auto found = open_.find(digest); found != open_.end()) {
      if (std::shared_ptr<const OpenBlob> blob = found->second.lock())
        return std::make_unique<FileBlobReader>(blob);
    }
    if (open_.size() >= kMostOpenBlobs)
      absl::erase_if(open_, [](const auto& entry) { return entry.second.expired(); });
    if (open_.size() >= kMostOpenBlobs) {
      return absl::ResourceExhaustedError(
          absl::StrCat(kMostOpenBlobs, " other blobs are read at this moment; try again"));
    }
    absl::StatusOr<File> file = File::open_existing(complete_path(digest));
    if (absl::IsNotFound(file.status()))
      return absl::NotFoundError(absl::StrCat("there is no blob ", digest));
    if (!file.ok()) return file.status();
    const absl::StatusOr<std::uint64_t> size = file->size();
    if (!size.ok()) return size.status();
    const auto blob = std::make_shared<const OpenBlob>(OpenBlob{.file = *std::move(file), .size = *size});
    open_[digest] = blob;
    return std::make_unique<FileBlobReader>(blob);
  }

  Collected collect(const std::function<bool(const std::string&)>& needed,
                    std::chrono::seconds unused) override {
    const auto limit = std::filesystem::file_time_type::clock::now() - unused;
    Collected collected;
    std::error_code error;
    for (std::filesystem::recursive_directory_iterator it(data_dir_ / "blobs", error), end;
         !error && it != end; it.increment(error)) {
      const std::string digest = it->path().filename().string();
      if (wire::is_digest(digest) && !needed(digest)) remove_unused(it->path(), limit, collected);
    }
    for (std::filesystem::directory_iterator it(data_dir_ / "partial", error), end; !error && it != end;
         it.increment(error)) {
      const auto guard = uploads_->hold(it->path().filename().string());
      if (guard != nullptr) remove_unused(it->path(), limit, collected);
    }
    return collected;
  }

  bool drop_unused(const std::string& digest, std::chrono::seconds unused) override {
    const auto limit = std::filesystem::file_time_type::clock::now() - unused;
    Collected collected;
    remove_unused(complete_path(digest), limit, collected);
    if (const auto guard = uploads_->hold(digest); guard != nullptr)
      remove_unused(partial_path(digest), limit, collected);
    return collected.blobs > 0;
  }

  absl::Status drop(const std::string& digest) override {
    std::error_code error;
    std::filesystem::remove(complete_path(digest), error);
    forget(digest);
    return error ? absl::ErrnoToStatus(error.value(), absl::StrCat("remove blob ", digest))
                 : absl::OkStatus();
  }

 private:
  /// Whoever reads the blob keeps its file; the next one finds another, or none.
  void forget(const std::string& digest) {
    const std::lock_guard lock(opening_);
    open_.erase(digest);
  }

  void remove_unused(const std::filesystem::path& path, std::filesystem::file_time_type limit,
                     Collected& collected) {
    const std::lock_guard lock(collecting_);
    std::error_code error;
    const auto used = std::filesystem::last_write_time(path, error);
    if (error || used > limit) return;
    const auto size = std::filesystem::file_size(path, error);
    if (error || !std::filesystem::remove(path, error)) return;
    forget(path.filename().string());
    ++collected.blobs;
    collected.bytes += size;
  }

  std::filesystem::path complete_path(const std::string& digest) const {
    return data_dir_ / "blobs" / digest.substr(0, 2) / digest;
  }
  std::filesystem::path partial_path(const std::string& digest) const {
    return data_dir_ / "partial" / digest;
  }

  const std::filesystem::path data_dir_;
  const DiskReserve reserve_;
  mutable std::mutex collecting_;
  mutable std::mutex opening_;
  mutable absl::flat_hash_map<std::string, std::weak_ptr<const OpenBlob>> open_;
  std::shared_ptr<UploadsUnderWay> uploads_ = std::make_shared<UploadsUnderWay>();
};

}  // namespace

std::unique_ptr<BlobStore> make_file_blob_store(const std::filesystem::path& data_dir, DiskReserve reserve) {
  return std::make_unique<FileBlobStore>(data_dir, std::move(reserve));
}

absl::Status drop_if_damaged(BlobStore& blobs, const std::string& digest) {
  const auto reader = blobs.read(digest);
  if (!reader.ok()) return reader.status();
  wire::Sha256 sha;
  absl::Status status;
  for (std::uint64_t at = 0; at < (*reader)->size() && status.ok();) {
    const absl::StatusOr<std::string> chunk = (*reader)->read(at, kHashChunkBytes);
    status = chunk.status();
    if (chunk.ok()) sha.update(*chunk);
    at += kHashChunkBytes;
  }
  if (status.ok() && sha.finish_hex() == digest) return absl::OkStatus();
  if (absl::Status dropped = blobs.drop(digest); !dropped.ok()) return dropped;
  return absl::NotFoundError(
      absl::StrCat("the coordinator's copy of blob ", digest,
                   " was damaged and is deleted: submit the scene again, which uploads it"));
}

}  // namespace tessera::server
