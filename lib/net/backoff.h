// How long to wait before a call is tried again.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <random>
#include <stop_token>

namespace tessera::net {

/// Exponential backoff with jitter: each delay is drawn from the upper half of a bound that doubles from
/// `first` to `cap`, so that workers which lost the same coordinator do not all come back at the same
/// instant.
class Backoff {
 public:
  using Duration = std::chrono::milliseconds;

  /// Absent: a random seed.
  explicit Backoff(Duration first = Duration{100}, Duration cap = Duration{5000},
                   std::optional<std::uint32_t> seed = std::nullopt);

  /// The delay before the next attempt.
  Duration next();

  /// After a success: the next delay is short again.
  void reset() { bound_ = first_; }

 private:
  Duration first_;
  Duration cap_;
  Duration bound_;
  const std::optional<std::uint32_t> seed_;
  std::optional<std::mt19937> random_;  // made when first needed: most calls succeed at once
};

/// Sleeps for `delay` by the machine's clock, or until `stop` is requested: then false.
bool interruptible_sleep(std::chrono::milliseconds delay, std::stop_token stop);

}  // namespace tessera::net
