// Content-addressed bytes, on disk or in memory. Safe to use from any number of threads.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "store/file.h"

namespace tessera::server {

struct UploadState {
  std::uint64_t stored_bytes = 0;
  bool complete = false;
};

/// One upload. What was appended stays for a later upload to go on with when the writer goes away unfinished.
class BlobWriter {
 public:
  virtual ~BlobWriter() = default;
  virtual absl::Status append(std::string_view bytes) = 0;
  /// Durable and visible once it returns OK. DataLoss when the bytes do not have the digest: all are dropped.
  virtual absl::Status finish() = 0;
};

class BlobReader {
 public:
  virtual ~BlobReader() = default;
  virtual std::uint64_t size() const = 0;
  /// At most `size` bytes from `offset` on; fewer at the end.
  virtual absl::StatusOr<std::string> read(std::uint64_t offset, std::size_t size) const = 0;
};

/// Digests must satisfy wire::is_digest.
class BlobStore {
 public:
  virtual ~BlobStore() = default;

  /// Counts as a use of the blob.
  virtual UploadState query(const std::string& digest) const = 0;

  /// AlreadyExists when the blob is complete; Unavailable while somebody else uploads it; OutOfRange when
  /// `offset` is not where the stored part ends (zero starts anew).
  virtual absl::StatusOr<std::unique_ptr<BlobWriter>> write(const std::string& digest,
                                                            std::uint64_t offset) = 0;

  /// ResourceExhausted when `bytes` more would leave less free than is kept for others; said with how much
  /// that is. Stores without a disk have room.
  virtual absl::Status check_room(std::uint64_t bytes) const { return absl::OkStatus(); }

  /// NotFound when the blob is not complete. ResourceExhausted while too many others are read.
  virtual absl::StatusOr<std::unique_ptr<BlobReader>> read(const std::string& digest) const = 0;

  /// Forgets a complete blob, that it may be uploaded again. Who reads it keeps its bytes.
  virtual absl::Status drop(const std::string& digest) = 0;
  /// Deletes one blob, or what is stored of it, that was neither written nor asked for (query) for `unused`:
  /// whether it did. Stores that last no longer than a process keep it.
  virtual bool drop_unused(const std::string& digest, std::chrono::seconds unused) { return false; }
  struct Collected {
    std::uint64_t blobs = 0;
    std::uint64_t bytes = 0;
  };
  /// Deletes what is not `needed` and was neither written nor asked for (query) for `unused`, parts of
  /// uploads that nobody goes on with included. Readers keep what they read. Stores that last no longer than
  /// a process keep everything.
  virtual Collected collect(const std::function<bool(const std::string& digest)>& needed,
                            std::chrono::seconds unused) {
    return {};
  }
};

/// Reads a complete blob and drops it when its bytes do not have its digest any more, or cannot be read:
/// NotFound, with what to do.
absl::Status drop_if_damaged(BlobStore& blobs, const std::string& digest);

/// Space that blobs leave free of their disk, for the journal and results that are on it too.
struct DiskReserve {
  /// 0: nothing. Absent: a twentieth of the disk, and at most kMostBytes. But for 0, a twentieth of the files
  /// that the disk can have, and at most kMostFiles, are kept as well: blobs may be small.
  std::optional<std::uint64_t> bytes = {};
  static constexpr std::uint64_t kMostBytes = 2'000'000'000;
  static constexpr std::uint64_t kMostFiles = 10'000;
  /// How much there is.
  std::function<absl::StatusOr<DiskSpace>(const std::filesystem::path&)> space = disk_space;
};

/// Below a data directory.
std::unique_ptr<BlobStore> make_file_blob_store(const std::filesystem::path& data_dir,
                                                DiskReserve reserve = {});

std::unique_ptr<BlobStore> make_memory_blob_store();

}  // namespace tessera::server
