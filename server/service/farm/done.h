// How calls are answered that may have to wait, for work or for the disk.
#pragma once

#include <functional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace tessera::server {

/// Called exactly once, from any thread, and maybe before the call that it answers returns.
template <typename T>
using Done = std::function<void(absl::StatusOr<T>)>;
using DoneEmpty = std::function<void(absl::Status)>;

}  // namespace tessera::server
