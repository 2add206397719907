// Work of libraries that hostile files can make recurse, or allocate, without end: in a process of its own.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "absl/status/statusor.h"

namespace tessera::client::assimp {

/// Bounds of what a process may take beyond what this one has now.
struct ProcessBounds {
  std::uint64_t memory_bytes = 0;
  std::uint64_t cpu_seconds = 0;
};

/// Returns what `work` returns in a copy of this process, whose threads it does not have. ResourceExhausted
/// where that process takes more, or ends before its work does; Internal where there can be none.
absl::StatusOr<std::string> run_apart(const ProcessBounds& bounds, const std::function<std::string()>& work);

}  // namespace tessera::client::assimp
