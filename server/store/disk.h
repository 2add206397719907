// Where the journal keeps its bytes: the machine's disk, or one that a test simulates.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace tessera::server {

class DiskFile {
 public:
  virtual ~DiskFile() = default;
  virtual absl::StatusOr<std::uint64_t> size() const = 0;
  /// Writes all of `bytes` at `offset`. ResourceExhausted when the disk is full.
  virtual absl::Status write_at(std::uint64_t offset, std::string_view bytes) = 0;
  /// Fills `out`, or DataLoss when the file is too short.
  virtual absl::Status read_at(std::uint64_t offset, char* out, std::size_t size) const = 0;
  /// Cuts the file, or lengthens it with zeros.
  virtual absl::Status truncate(std::uint64_t size) = 0;
  /// Returns when the contents are on the disk.
  virtual absl::Status sync() = 0;
};

class Disk {
 public:
  virtual ~Disk() = default;
  /// For reading and writing; made when it does not exist and `create` is set, else NotFound.
  virtual absl::StatusOr<std::unique_ptr<DiskFile>> open(const std::filesystem::path& path, bool create) = 0;
  /// No error when there is no such file.
  virtual absl::Status remove(const std::filesystem::path& path) = 0;
  /// Replaces `to`. No error when there is no `from`.
  virtual absl::Status move(const std::filesystem::path& from, const std::filesystem::path& to) = 0;
  /// Names within a directory, sorted; none when it is not there.
  virtual absl::StatusOr<std::vector<std::string>> list(const std::filesystem::path& directory) = 0;
  /// Returns when the contents of all files are on the disk; the first error. One after another, unless a
  /// disk knows better.
  virtual absl::Status sync(const std::vector<DiskFile*>& files);
  /// Makes new entries within `directory` durable.
  virtual absl::Status sync_directory(const std::filesystem::path& directory) = 0;
  /// The name of the SQLite VFS that reads and writes the same disk; empty: SQLite's own.
  virtual std::string sqlite_vfs() const = 0;
};

/// The machine's own. Lives as long as the program.
Disk& machine_disk();

}  // namespace tessera::server
