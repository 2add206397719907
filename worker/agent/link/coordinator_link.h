// The worker's calls to the coordinator: a deadline on each, errors that name the RPC and the address.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "tessera/v1/work.pb.h"
#include "transport/backoff.h"

namespace grpc {
class Channel;
}

namespace tessera::agent {

/// Thread-safe. Every call blocks until its reply, its deadline, or until `stop` is requested (then
/// Cancelled). No call retries by itself.
class CoordinatorLink {
 public:
  /// `address` is for messages only.
  CoordinatorLink(std::shared_ptr<grpc::Channel> channel, std::string address);
  ~CoordinatorLink();

  absl::StatusOr<v1::RegisterResponse> register_worker(const v1::RegisterRequest& request,
                                                       std::stop_token stop);
  /// The deadline is the request's `max_wait` and a margin.
  absl::StatusOr<v1::LeaseResponse> lease(const v1::LeaseRequest& request, std::stop_token stop);
  absl::StatusOr<v1::HeartbeatResponse> heartbeat(const v1::HeartbeatRequest& request, std::stop_token stop);
  absl::StatusOr<v1::CompleteResponse> complete(const v1::CompleteRequest& request, std::stop_token stop);
  absl::Status fail(const v1::FailRequest& request, std::stop_token stop);
  absl::Status deregister(const v1::DeregisterRequest& request);

  using ChunkSink = std::function<absl::Status(std::string_view chunk)>;
  struct Wanted {
    std::string digest;
    std::uint64_t offset = 0;
    bool doubted = false;  // it came with another digest before (blob.proto)
  };
  /// Streams the blob's bytes from the offset on into `sink`, whose error ends the call. DeadlineExceeded
  /// when no chunk has come for 30 s.
  absl::Status download(const Wanted& wanted, const ChunkSink& sink, std::stop_token stop);

  /// Stores the bytes under their digest with the coordinator, unless it has them; as transport::upload_rest.
  absl::Status upload(const v1::BlobRef& blob, std::string_view bytes, std::stop_token stop);

  /// Waits before a call is tried again: for the back-off's delay, or until the coordinator is connected
  /// again. False when `stop` was requested meanwhile.
  bool wait(transport::Backoff& backoff, std::stop_token stop);

  const std::string& address() const { return address_; }

 private:
  struct Stubs;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<Stubs> stubs_;
  std::string address_;
};

}  // namespace tessera::agent
