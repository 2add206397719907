// Loops over several threads.
#pragma once

#include <cstddef>
#include <functional>

#include "absl/status/status.h"

namespace tessera::render {

/// f(0) .. f(n - 1) on up to `threads` threads; the first error that any returned.
absl::Status parallel_for(std::size_t n, int threads, const std::function<absl::Status(std::size_t)>& f);

}  // namespace tessera::render
