// Which random worlds a test runs: TESSERA_SCHEDULES=N in the environment runs that many seeds, from
// TESSERA_FIRST_SEED on, for runs by hand and to repeat a failure.
#pragma once

#include <cstdint>
#include <cstdlib>

namespace tessera::server {

inline std::uint64_t number_from(const char* variable, std::uint64_t otherwise) {
  const char* const text = std::getenv(variable);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

struct Seeds {
  std::uint64_t first = 0, count = 0;
};

inline Seeds seeds_from_environment(std::uint64_t count) {
  return {.first = number_from("TESSERA_FIRST_SEED", 0), .count = number_from("TESSERA_SCHEDULES", count)};
}

}  // namespace tessera::server
