// Uploads, until a job names their blobs: what they cost, and whom their bytes count against.
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
  /// The upload of a blob of `size` bytes begins, or goes on: all of them count against `holder`, and against
  /// nobody who began it before.
  void begin(const std::string& digest, std::uint64_t size, const std::string& holder, TimePoint now);
  /// Adds bytes that were sent of a blob.
  void note(const std::string& digest, std::uint64_t bytes, TimePoint now);
  /// No job will be told what this one cost.
  void forget(const std::string& digest) { take(digest); }
  /// Returns what the job's blobs cost, each told once.
  std::uint64_t claim(const v1::JobSpec& spec);

  /// Bytes that count against `holder`, but for blobs that `spec` names.
  std::uint64_t held_by(const std::string& holder, const v1::JobSpec& spec = {}) const;
  /// The same, but for one blob.
  std::uint64_t held_by(const std::string& holder, const std::string& but_for) const;

 private:
  struct Upload {
    std::uint64_t sent = 0, size = 0;
    std::string holder = {};
  };
  using Uploads = absl::flat_hash_map<std::string, Upload>;  // key: digest

  Upload take(const std::string& digest);
  void put(const std::string& digest, Upload upload, TimePoint now);
  /// Bytes of the blob that count against `holder`.
  std::uint64_t held_of(const std::string& holder, const std::string& digest) const;

  const std::chrono::seconds lifetime_;
  TimePoint next_turn_{};
  Uploads uploads_, older_;
  absl::flat_hash_map<std::string, std::uint64_t> held_;
};

}  // namespace tessera::server
