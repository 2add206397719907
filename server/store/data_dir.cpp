#include "store/data_dir.h"

#include <sys/file.h>

#include "absl/strings/str_cat.h"

namespace tessera::server {

namespace {

namespace fs = std::filesystem;

/// Nobody but this user may read what is in the directory, whatever it was before: jobs, images, and the key
/// that leases are sealed with. Files of deeper directories are safe behind those.
absl::Status make_private(const fs::path& directory) {
  std::error_code error;
  // That of a mounted volume may be somebody else's; what is in it is not.
  fs::permissions(directory, fs::perms::owner_all, error);
  const fs::directory_iterator entries(directory, error);
  if (error) return absl::ErrnoToStatus(error.value(), absl::StrCat("read directory ", directory.string()));
  for (const fs::directory_entry& entry : entries) {
    const fs::file_status status = entry.symlink_status();
    if (!fs::is_directory(status) && !fs::is_regular_file(status)) continue;
    const fs::perms wanted =
        fs::is_directory(status) ? fs::perms::owner_all : fs::perms::owner_read | fs::perms::owner_write;
    if (status.permissions() == wanted) continue;
    fs::permissions(entry.path(), wanted, error);
    if (error) {
      return absl::FailedPreconditionError(
          absl::StrCat(entry.path().string(), " may be read by others, and this user cannot change that (",
                       error.message(), "): chown it to the user of the coordinator"));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<DataDir> DataDir::open(const std::filesystem::path& path) {
  for (const char* part : {"results", "blobs", "partial"}) {
    if (absl::Status status = make_directory(path / part); !status.ok()) return status;
  }
  absl::StatusOr<File> lock = File::open_or_create(path / "lock");
  if (!lock.ok()) return lock.status();
  if (::flock(lock->descriptor(), LOCK_EX | LOCK_NB) != 0) {
    return absl::FailedPreconditionError(
        absl::StrCat("data directory ", path.string(), " is in use by another coordinator"));
  }
  if (absl::Status status = make_private(path); !status.ok()) return status;
  return DataDir(path, *std::move(lock));
}

}  // namespace tessera::server
