// Times as the files of this room hold them.
#pragma once

#include <chrono>
#include <cstdint>

namespace tessera::server {

/// Returns whole seconds since 1970, rounded down.
inline std::int64_t unix_seconds(std::chrono::system_clock::time_point time) {
  return std::chrono::floor<std::chrono::seconds>(time).time_since_epoch().count();
}

}  // namespace tessera::server
