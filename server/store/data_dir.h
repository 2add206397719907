// The directory in which a coordinator keeps its state, held by one process at a time.
//
//   lock                     held while a coordinator runs
//   journal.sqlite           jobs and results (journal.h)
//   manifest                 what the journal must hold (manifest.h)
//   farm.log                 what was journaled of the whole farm (entry_log.h)
//   results/JOB              payloads of a job's results, one after another (result_file.h)
//   results/JOB.log          all else that was journaled of the job
//   lease-key, expelled, join-tokens    small files of their own (service/farm/lease_seal.h, tls/)
//   blobs/ab/abcdef...       blobs, named by digest (blob_store.h)
//   partial/abcdef...        uploads that are not complete
#pragma once

#include <filesystem>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "store/file.h"

namespace tessera::server {

inline std::filesystem::path result_path(const std::filesystem::path& data_dir, const std::string& job) {
  return data_dir / "results" / job;
}
/// The farm's for an empty `job`.
inline std::filesystem::path log_path(const std::filesystem::path& data_dir, const std::string& job) {
  return job.empty() ? data_dir / "farm.log" : data_dir / "results" / (job + ".log");
}

class DataDir {
 public:
  /// Makes the directory where there is none, takes the lock, and takes the rights of other users away.
  /// FailedPrecondition when another process holds it, or a file in it belongs to another user.
  static absl::StatusOr<DataDir> open(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return path_; }

 private:
  DataDir(std::filesystem::path path, File lock) : path_(std::move(path)), lock_(std::move(lock)) {}

  std::filesystem::path path_;
  File lock_;  // released by the kernel when the process ends, however it ends
};

}  // namespace tessera::server
