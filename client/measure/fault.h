#pragma once

#include <string>

#include "absl/status/status.h"

namespace tessera::client {

/// InvalidArgument: what is wrong with a meter.
inline absl::Status fault(const std::string& what) { return absl::InvalidArgumentError(what); }

}  // namespace tessera::client
