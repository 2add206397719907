// Ending long work early.
#pragma once

#include <cstddef>
#include <exception>
#include <stop_token>

namespace tessera::render {

/// Thrown out of work that was told to stop; whoever began the work catches it and says Cancelled.
struct Stopped : std::exception {
  const char* what() const noexcept override { return "stopped"; }
};

inline void throw_if_stopped(const std::stop_token& stop) {
  if (stop.stop_requested()) throw Stopped();
}

/// Looks at `stop` for one in 1024 values of `i`: for loops whose steps take less than a microsecond.
inline void throw_if_stopped(const std::stop_token& stop, std::size_t i) {
  if (i % 1024 == 0) throw_if_stopped(stop);
}

}  // namespace tessera::render
