// Tests with a short form that everybody runs, and a long one (ctest entries NAME_long, label `long`).
#pragma once

#include <cstdlib>
#include <string_view>

namespace tessera::test {

/// Whether this is the long form: tessera_test(... LONG seconds) sets TESSERA_TEST_FORM for it.
inline bool long_form() {
  const char* form = std::getenv("TESSERA_TEST_FORM");
  return form != nullptr && std::string_view(form) == "long";
}

}  // namespace tessera::test
