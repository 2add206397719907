// A job's blobs: out of the cache, or from the coordinator.
#pragma once

#include <atomic>
#include <cstdint>
#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "agent/agent.h"
#include "agent/link/coordinator_link.h"
#include "agent/stores/blob_cache.h"
#include "base/clock.h"
#include "tessera/v1/job.pb.h"

namespace tessera::agent {

/// Thread-safe.
class BlobFetcher {
 public:
  BlobFetcher(base::Clock& clock, CoordinatorLink& link, BlobCache& cache);

  /// The blob's bytes. A download that breaks off goes on where it broke, for as long as the coordinator may
  /// come back; a blob that comes with the wrong bytes three times is DataLoss. Cancelled when `stop` is
  /// requested.
  absl::StatusOr<render::BlobBytes> get(const std::string& digest, std::stop_token stop);

  /// Nobody here needs the blob any more.
  void drop(const std::string& digest) { cache_.drop(digest); }

  /// Brings everything that the job's scene refers to into the cache, in the order of use and several blobs
  /// at once. Stops early, without a word, at the first failure: whoever needs that blob will meet it.
  void prefetch(const v1::JobSpec& spec, std::stop_token stop);

  void add_to(AgentReport& report) const;

 private:
  base::Clock& clock_;
  CoordinatorLink& link_;
  BlobCache& cache_;
  std::atomic<std::uint64_t> downloaded_bytes_{0};
  std::atomic<std::uint64_t> hits_{0}, misses_{0};
};

}  // namespace tessera::agent
