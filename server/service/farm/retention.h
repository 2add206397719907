// How long jobs that are over, and blobs, are kept.
#pragma once

#include <chrono>
#include <cstdint>

namespace tessera::server {

struct Retention {
  std::chrono::seconds fetched;    // time after its end, when a client has the image
  std::chrono::seconds unfetched;  // lifetime where no client has them, or something is missing
  /// Beyond so many bytes of results, jobs that were fetched go earlier, the oldest first.
  std::uint64_t max_bytes;
  std::chrono::seconds blobs;          // lifetime of blobs that no job refers to, after their last use
  std::chrono::milliseconds interval;  // time between two looks at all this
};

}  // namespace tessera::server
