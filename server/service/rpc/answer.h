// Ends a unary call with a response or an error.
#pragma once

#include <grpcpp/grpcpp.h>

#include <utility>

#include "absl/status/statusor.h"
#include "net/status.h"

namespace tessera::server {

inline grpc::ServerUnaryReactor* answer(grpc::ServerUnaryReactor* reactor, const absl::Status& status) {
  reactor->Finish(net::to_grpc(status));
  return reactor;
}

template <typename Response>
grpc::ServerUnaryReactor* answer(grpc::ServerUnaryReactor* reactor, absl::StatusOr<Response> result,
                                 Response* response) {
  if (!result.ok()) return answer(reactor, result.status());
  *response = *std::move(result);
  return answer(reactor, absl::OkStatus());
}

}  // namespace tessera::server
