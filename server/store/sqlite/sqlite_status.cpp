#include "store/sqlite/sqlite_status.h"

#include <sqlite3.h>

#include "absl/strings/str_cat.h"

namespace tessera::server {

absl::Status status_of(const SQLite::Exception& error, const char* what) {
  const std::string message = absl::StrCat("journal, ", what, ": ", error.what());
  if (error.getExtendedErrorCode() == SQLITE_IOERR_DATA) {
    return absl::DataLossError(
        absl::StrCat(message, ": a page does not have its checksum, so the file is damaged"));
  }
  switch (error.getErrorCode()) {
    case SQLITE_FULL:
      return absl::ResourceExhaustedError(message);
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return absl::DataLossError(message);
    default:
      return absl::InternalError(message);
  }
}

}  // namespace tessera::server
