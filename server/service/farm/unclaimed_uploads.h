// Cost of uploads, until a job names their blobs.
#pragma once

#include <cstdint>
#include <string>

#include "absl/container/flat_hash_map.h"
#include "tessera/v1/job.pb.h"

namespace tessera::server {

/// Not thread-safe.
class UnclaimedUploads {
 public:
  /// Adds bytes that were sent of a blob.
  void note(const std::string& digest, std::uint64_t bytes) { bytes_[digest] += bytes; }
  /// No job will be told what this one cost.
  void forget(const std::string& digest) { bytes_.erase(digest); }
  /// Returns what the job's blobs cost, each told once.
  std::uint64_t claim(const v1::JobSpec& spec);

 private:
  absl::flat_hash_map<std::string, std::uint64_t> bytes_;
};

}  // namespace tessera::server
