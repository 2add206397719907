// POSIX files with errors as absl::Status, naming the path.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace tessera::server {

/// An open file descriptor.
class File {
 public:
  /// For reading and appending; made when it does not exist.
  static absl::StatusOr<File> open_or_create(const std::filesystem::path& path);
  /// For reading. NotFound when it does not exist.
  static absl::StatusOr<File> open_existing(const std::filesystem::path& path);
  /// Without a name, in memory; gone when closed.
  static absl::StatusOr<File> in_memory();

  File(File&& other) noexcept;
  File& operator=(File&& other) noexcept;
  ~File();

  absl::StatusOr<std::uint64_t> size() const;
  /// Writes all of `bytes` at `offset`. ResourceExhausted when the disk is full.
  absl::Status write_at(std::uint64_t offset, std::string_view bytes);
  /// Fills `out`, or DataLoss when the file is too short.
  absl::Status read_at(std::uint64_t offset, char* out, std::size_t size) const;
  absl::Status truncate(std::uint64_t size);
  /// Returns when the contents are on the disk.
  absl::Status sync();

  int descriptor() const { return descriptor_; }

 private:
  File(int descriptor, std::filesystem::path path);
  absl::Status error(const char* what) const;

  int descriptor_;
  std::filesystem::path path_;  // named in messages
};

/// Space of a file system, for whoever is not root. Both numbers of files are 0 where they have no limit.
struct DiskSpace {
  std::uint64_t free_bytes = 0, total_bytes = 0;
  std::uint64_t free_files = 0, total_files = 0;
};
/// Space of the file system that holds `path`.
absl::StatusOr<DiskSpace> disk_space(const std::filesystem::path& path);

/// Makes renames and new entries within `directory` durable.
absl::Status sync_directory(const std::filesystem::path& directory);

/// Replaces `to` at once. The caller syncs the directory.
absl::Status rename_file(const std::filesystem::path& from, const std::filesystem::path& to);

/// Makes the directory and those above it.
absl::Status make_directory(const std::filesystem::path& directory);

}  // namespace tessera::server
