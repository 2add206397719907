// Messages from pieces of text and numbers.
#pragma once

#include <string>
#include <string_view>
#include <type_traits>

#include "absl/strings/str_cat.h"

namespace tessera::client {

/// absl::StrCat for std::string_view too: Abseil may have been built with a string_view of its own, as in
/// Debian 12.
template <typename... Parts>
std::string concat(const Parts&... parts) {
  const auto accepted = []<typename T>(const T& part) -> decltype(auto) {
    if constexpr (std::is_same_v<T, std::string_view>) {
      return absl::string_view(part.data(), part.size());
    } else {
      return (part);
    }
  };
  return absl::StrCat(accepted(parts)...);
}

}  // namespace tessera::client
