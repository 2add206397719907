// The time by which a coordinator lives.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

namespace tessera::server {

/// Tells the time, and lets threads wait for it. Safe to use from any number of threads.
class FarmClock {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  virtual ~FarmClock() = default;
  /// Monotonic.
  virtual TimePoint now() const = 0;
  /// Time on the wall, which somebody may set; since 1970.
  virtual std::chrono::milliseconds wall() const = 0;
  /// Waits until `changed` is notified, it is `deadline`, or for no reason. `lock` holds the mutex that goes
  /// with `changed`.
  virtual void wait_until(std::unique_lock<std::mutex>& lock, std::condition_variable& changed,
                          TimePoint deadline) = 0;
};

/// The machine's.
FarmClock& machine_clock();

}  // namespace tessera::server
