// The one mapping between absl::Status and grpc::Status.
#pragma once

#include <string_view>

#include "absl/status/status.h"

namespace grpc {
class Status;
}

namespace tessera::net {

grpc::Status to_grpc(const absl::Status& status);

/// `call` names the RPC and the address for the message: "Lease at 127.0.0.1:7070".
absl::Status from_grpc(const grpc::Status& status, std::string_view call);

/// True for errors of a call that may go away by themselves: the coordinator restarts, is overloaded, or
/// cannot be reached.
bool is_transient(const absl::Status& status);

/// True for errors by which a coordinator turns a caller away: no credentials, no right, another version. Any
/// other answer may be to a request that suffered on its way: gRPC answers UNIMPLEMENTED, without a message,
/// to bytes that it cannot parse.
bool is_refusal(const absl::Status& status);

}  // namespace tessera::net
