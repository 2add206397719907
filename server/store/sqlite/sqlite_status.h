// SQLiteCpp speaks in exceptions; they end here.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include "absl/status/status.h"

namespace tessera::server {

/// DataLoss for a damaged database, ResourceExhausted for a full disk, else Internal.
absl::Status status_of(const SQLite::Exception& error, const char* what);

/// Calls `function`, which returns a status and may throw SQLite::Exception. `what` is for messages.
template <typename Function>
absl::Status guarded(const char* what, Function function) {
  try {
    return function();
  } catch (const SQLite::Exception& error) {
    return status_of(error, what);
  }
}

}  // namespace tessera::server
