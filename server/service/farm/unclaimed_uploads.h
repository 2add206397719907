// Cost of uploads, until a job names their blobs.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "absl/container/flat_hash_map.h"
#include "tessera/v1/job.pb.h"

namespace tessera::server {

/// Not thread-safe.
class UnclaimedUploads {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  /// An upload that no job has named is forgotten between `lifetime` and twice that after it was sent: by
  /// then the blob is gone, too.
  explicit UnclaimedUploads(std::chrono::seconds lifetime) : lifetime_(lifetime) {}
  /// Adds bytes that were sent of a blob.
  void note(const std::string& digest, std::uint64_t bytes, TimePoint now);
  /// No job will be told what this one cost.
  void forget(const std::string& digest) { take(digest); }
  /// Returns what the job's blobs cost, each told once.
  std::uint64_t claim(const v1::JobSpec& spec);

 private:
  std::uint64_t take(const std::string& digest);

  const std::chrono::seconds lifetime_;
  TimePoint next_turn_{};
  absl::flat_hash_map<std::string, std::uint64_t> bytes_, older_;
};

}  // namespace tessera::server
