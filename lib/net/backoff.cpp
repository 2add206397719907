#include "net/backoff.h"

#include <algorithm>

#include "base/clock.h"

namespace tessera::net {

Backoff::Backoff(Duration first, Duration cap, std::optional<std::uint32_t> seed)
    : first_(first), cap_(cap), bound_(first), seed_(seed) {}

Backoff::Duration Backoff::next() {
  if (!random_) random_.emplace(seed_ ? *seed_ : std::random_device{}());
  const Duration delay{
      std::uniform_int_distribution<Duration::rep>{bound_.count() / 2, bound_.count()}(*random_)};
  bound_ = std::min(2 * bound_, cap_);
  return delay;
}

bool interruptible_sleep(std::chrono::milliseconds delay, std::stop_token stop) {
  return base::pause(base::machine_clock(), delay, stop);
}

}  // namespace tessera::net
