// Manifest of what the journal must hold: a small file beside it, so that a loss is known as one
// [docs/decisions/0002-journal-format.md].
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "store/disk.h"

namespace tessera::server {

/// Counts of what was committed.
struct ManifestCounts {
  std::uint64_t epoch = 0;
  std::uint64_t commit = 0;      // the last
  std::uint64_t jobs = 0;        // number of jobs
  std::uint64_t results = 0;     // number of their results
  std::uint64_t checkpoint = 0;  // the last commit when SQLite's log was last copied into its database
  std::uint64_t damaged = 0;  // 1: a page of the database could not be read, so that it has to be made anew
};

/// Two slots, written in turn, each with a checksum: a torn write leaves the other.
class Manifest {
 public:
  /// `found` is what the file holds; nothing when it is not there, or neither slot is whole.
  static absl::StatusOr<Manifest> open(Disk& disk, const std::filesystem::path& path);

  const std::optional<ManifestCounts>& found() const { return found_; }

  /// Survives the process; also the machine only after `file_to_sync` was synced.
  absl::Status write(const ManifestCounts& counts);
  DiskFile& file_to_sync() const { return *file_; }

 private:
  explicit Manifest(std::unique_ptr<DiskFile> file) : file_(std::move(file)) {}

  std::unique_ptr<DiskFile> file_;
  std::optional<ManifestCounts> found_;
  std::uint64_t writes_ = 0;
};

}  // namespace tessera::server
