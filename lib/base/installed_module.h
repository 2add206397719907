// Parts of the programs that few runs need: libraries beside them, opened when they are.
#pragma once

#include <string_view>

#include "absl/status/statusor.h"

namespace tessera::base {

/// Opens `file`, which is found by the program's run path, and returns its symbol `entry`. It is never
/// closed: its own libraries may keep threads and tables. FailedPrecondition, which begins with `what`
/// ("images cannot be read"), where it is not there.
absl::StatusOr<void*> installed_module(const char* file, const char* entry, std::string_view what);

}  // namespace tessera::base
