#pragma once

#include <chrono>
#include <thread>

namespace tessera::load {

/// Reached only when something hangs.
inline constexpr std::chrono::seconds kPatience{100};

/// Waits until the condition holds, and returns whether it did in time.
template <typename Condition>
bool wait_for(Condition condition, std::chrono::steady_clock::duration patience = kPatience) {
  const auto end = std::chrono::steady_clock::now() + patience;
  while (!condition() && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return condition();
}

}  // namespace tessera::load
