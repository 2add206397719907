#include "net/status.h"

#include <grpcpp/support/status.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "base/printable.h"

namespace tessera::net {

// The numbers of absl::StatusCode and grpc::StatusCode are the same by design of both.
static_assert(static_cast<int>(absl::StatusCode::kUnauthenticated) == grpc::StatusCode::UNAUTHENTICATED);
static_assert(static_cast<int>(absl::StatusCode::kDataLoss) == grpc::StatusCode::DATA_LOSS);
static_assert(static_cast<int>(absl::StatusCode::kFailedPrecondition) ==
              grpc::StatusCode::FAILED_PRECONDITION);

grpc::Status to_grpc(const absl::Status& status) {
  if (status.ok()) return grpc::Status::OK;
  return {static_cast<grpc::StatusCode>(status.code()), std::string(status.message())};
}

absl::Status from_grpc(const grpc::Status& status, std::string_view call) {
  if (status.ok()) return absl::OkStatus();
  const std::string why = base::printable(status.error_message());  // text from the other end
  const bool unread = status.error_code() == grpc::StatusCode::UNIMPLEMENTED && why.empty();
  return {static_cast<absl::StatusCode>(status.error_code()),
          absl::StrCat(std::string(call), ": ",
                       unread ? "the call is not known there, or could not be read" : why)};
}

bool is_transient(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kCancelled:  // by a server that ends: callers know themselves what they cancelled
    case absl::StatusCode::kDeadlineExceeded:
    case absl::StatusCode::kResourceExhausted:
    case absl::StatusCode::kAborted:
    case absl::StatusCode::kInternal:
    case absl::StatusCode::kUnknown:
      return true;
    default:
      return false;
  }
}

bool is_refusal(const absl::Status& status) {
  return absl::IsFailedPrecondition(status) || absl::IsPermissionDenied(status) ||
         absl::IsUnauthenticated(status);
}

}  // namespace tessera::net
