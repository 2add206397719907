#include "store/data_dir.h"

#include <sys/file.h>

#include "absl/strings/str_cat.h"

namespace tessera::server {

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
  return DataDir(path, *std::move(lock));
}

}  // namespace tessera::server
