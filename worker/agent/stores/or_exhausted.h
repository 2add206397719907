// Exceptions of work that others wait for, as statuses.
#pragma once

#include <exception>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace tessera::agent {

/// Returns what `work` returns, a status or StatusOr; ResourceExhausted where it throws, out of memory above
/// all. `doing` begins the message.
template <class Work>
auto or_exhausted(const std::string& doing, Work&& work) -> decltype(work()) {
  try {
    return std::forward<Work>(work)();
  } catch (const std::exception& error) {
    return absl::ResourceExhaustedError(absl::StrCat(doing, ": ", error.what()));
  }
}

}  // namespace tessera::agent
