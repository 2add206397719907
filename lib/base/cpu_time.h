// Processor time, the measure of what work costs: waiting for a processor does not count.
#pragma once

#include <time.h>

#include <chrono>

namespace tessera::base {

namespace internal {
inline std::chrono::nanoseconds read_clock(clockid_t clock) {
  timespec now{};
  ::clock_gettime(clock, &now);
  return std::chrono::seconds{now.tv_sec} + std::chrono::nanoseconds{now.tv_nsec};
}
}  // namespace internal

/// CPU time of the calling thread.
inline std::chrono::nanoseconds thread_cpu_time() { return internal::read_clock(CLOCK_THREAD_CPUTIME_ID); }

/// CPU time of all threads of this process.
inline std::chrono::nanoseconds process_cpu_time() { return internal::read_clock(CLOCK_PROCESS_CPUTIME_ID); }

inline double in_seconds(std::chrono::nanoseconds time) {
  return std::chrono::duration<double>(time).count();
}

}  // namespace tessera::base
