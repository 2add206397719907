// Limits, times and checks that calls of workers share. For farm_workers.cpp and farm_results.cpp.
#pragma once

#include <algorithm>
#include <chrono>

#include "service/metrics.h"
#include "tessera/v1/work.pb.h"
#include "wire/limits.h"

namespace tessera::server {

inline constexpr int kMaxNamedPerLease = 256;  // jobs or scenes that a worker says it knows
/// Bytes of a call that waits, with all its names.
inline constexpr std::size_t kMaxLeaseBytes = std::size_t{32} << 10;

/// Measures how long a call takes, its wait for the lock included.
class Served {
 public:
  Served(FarmMetrics& metrics, FarmMetrics::Call call) : metrics_(metrics), call_(call) {}
  ~Served() { metrics_.served(call_, std::chrono::steady_clock::now() - start_); }
  Served(const Served&) = delete;
  Served& operator=(const Served&) = delete;

 private:
  FarmMetrics& metrics_;
  const FarmMetrics::Call call_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Whether the request names no more jobs and scenes than a call that waits may hold.
inline bool names_few(const v1::LeaseRequest& request) {
  return std::max(request.known_job_ids_size(), request.loaded_scene_digests_size()) <= kMaxNamedPerLease &&
         request.ByteSizeLong() <= kMaxLeaseBytes;
}

}  // namespace tessera::server
