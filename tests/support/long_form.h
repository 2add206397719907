// Tests with a short form that everybody runs, and a long one (ctest entries NAME_long, label `long`).
#pragma once

#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

namespace tessera::test {

/// Whether this is the long form: tessera_test(... LONG seconds) sets TESSERA_TEST_FORM for it.
inline bool long_form() {
  const char* form = std::getenv("TESSERA_TEST_FORM");
  return form != nullptr && std::string_view(form) == "long";
}

/// How often a test does what it does at random: as the environment variable says, for runs by hand, else one
/// number for the short form and one for the long.
inline std::uint64_t how_often(const char* variable, std::uint64_t in_short_form,
                               std::uint64_t in_long_form) {
  const char* number = std::getenv(variable);
  if (number != nullptr) return std::stoull(number);
  return long_form() ? in_long_form : in_short_form;
}

}  // namespace tessera::test
