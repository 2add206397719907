// Calls from workers and clients to the coordinator. For the few sources that include gRPC.
#pragma once

#include <grpcpp/client_context.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "net/status.h"

namespace tessera::net {

/// One unary call, abandoned with Cancelled when `stop` is requested. Errors name the call and the address.
template <class Stub, class Request, class Response>
absl::StatusOr<Response> unary_call(Stub& stub,
                                    grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&,
                                                                 Response*),
                                    const Request& request, const char* name, const std::string& address,
                                    std::chrono::milliseconds timeout, std::stop_token stop) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + timeout);
  std::stop_callback cancel{stop, [&context] { context.TryCancel(); }};
  Response response;
  const grpc::Status status = (stub.*method)(&context, request, &response);
  if (!status.ok()) return from_grpc(status, absl::StrCat(name, " at ", address));
  return response;
}

/// Cancels a streaming call that makes no progress for `limit`. (gRPC's deadline is for the whole call, and a
/// large blob or a long job may take any time.) Must be destroyed before the context.
class StallGuard {
 public:
  StallGuard(grpc::ClientContext& context, std::chrono::milliseconds limit);

  /// A message went through.
  void progress();

  /// True when the guard cancelled the call.
  bool stalled();

 private:
  void watch(grpc::ClientContext& context, std::chrono::milliseconds limit, std::stop_token stop);

  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::uint64_t messages_ = 0;
  bool stalled_ = false;
  std::jthread thread_;
};

}  // namespace tessera::net
