#include "command/exit_code.h"

#include <iostream>
#include <string>

#include "base/printable.h"

namespace tessera::client {

int report(ExitCode code, const std::string& message) {
  std::cerr << "tessera: " << base::printable_lines(message) << std::endl;
  return code;
}

int report_farm_error(const absl::Status& status) {
  const std::string message{status.message()};
  switch (status.code()) {
    case absl::StatusCode::kCancelled:
      return report(kInterrupted, message);
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kNotFound:
      return report(kUsage, message);
    case absl::StatusCode::kDataLoss:
      return report(kJobFailed, message);
    default:
      return report(kUnreachable, message);
  }
}

}  // namespace tessera::client
