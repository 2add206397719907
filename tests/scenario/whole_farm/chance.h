// Decisions that follow from a seed.
#pragma once

#include <chrono>
#include <cstdint>
#include <random>

namespace tessera::test {

class Chance {
 public:
  explicit Chance(std::uint64_t seed) : random_(seed) {}

  std::uint64_t below(std::uint64_t end) { return random_() % end; }
  bool of(double probability) { return static_cast<double>(random_() % 1'000'000) < probability * 1e6; }
  /// Evenly between the two.
  std::chrono::milliseconds between(std::chrono::milliseconds least, std::chrono::milliseconds most) {
    return least + std::chrono::milliseconds(below(static_cast<std::uint64_t>((most - least).count()) + 1));
  }

 private:
  std::mt19937_64 random_;
};

}  // namespace tessera::test
