// The directory in which a coordinator keeps its state, held by one process at a time.
//
//   lock                     held while a coordinator runs
//   journal.sqlite           jobs and results (journal.h)
//   results/JOB              payloads of a job's results, one after another (result_file.h)
//   blobs/ab/abcdef...       blobs, named by digest (blob_store.h)
//   partial/abcdef...        uploads that are not complete
#pragma once

#include <filesystem>
#include <utility>

#include "absl/status/statusor.h"
#include "store/file.h"

namespace tessera::server {

class DataDir {
 public:
  /// Makes the directory where there is none, and takes the lock. FailedPrecondition when another process holds it.
  static absl::StatusOr<DataDir> open(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return path_; }

 private:
  DataDir(std::filesystem::path path, File lock) : path_(std::move(path)), lock_(std::move(lock)) {}

  std::filesystem::path path_;
  File lock_;  // released by the kernel when the process ends, however it ends
};

}  // namespace tessera::server
