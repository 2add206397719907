// The worker's calls to the coordinator, wherever that is.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>

#include "absl/status/statusor.h"
#include "net/backoff.h"
#include "tessera/v1/work.pb.h"

namespace tessera::agent {

/// Thread-safe. Every call blocks until its reply, its deadline where it has one, or until `stop` is
/// requested (then Cancelled). No call retries by itself.
class CoordinatorLink {
 public:
  /// `address` is for messages only.
  explicit CoordinatorLink(std::string address) : address_(std::move(address)) {}
  virtual ~CoordinatorLink() = default;

  virtual absl::StatusOr<v1::RegisterResponse> register_worker(const v1::RegisterRequest& request,
                                                               std::stop_token stop) = 0;
  virtual absl::StatusOr<v1::LeaseResponse> lease(const v1::LeaseRequest& request, std::stop_token stop) = 0;
  virtual absl::StatusOr<v1::HeartbeatResponse> heartbeat(const v1::HeartbeatRequest& request,
                                                          std::stop_token stop) = 0;
  virtual absl::StatusOr<v1::CompleteResponse> complete(const v1::CompleteRequest& request,
                                                        std::stop_token stop) = 0;
  virtual absl::Status fail(const v1::FailRequest& request, std::stop_token stop) = 0;
  virtual absl::Status deregister(const v1::DeregisterRequest& request) = 0;

  using ChunkSink = std::function<absl::Status(std::string_view chunk)>;
  struct Wanted {
    std::string digest;
    std::uint64_t offset = 0;
    bool doubted = false;  // it came with another digest before (blob.proto)
  };
  /// Hands the blob's bytes from the offset on to `sink`, whose error ends the call.
  virtual absl::Status download(const Wanted& wanted, const ChunkSink& sink, std::stop_token stop) = 0;

  /// A blob that a worker uploads, and the lease that calls for it.
  struct UnitBlob {
    v1::BlobRef ref;
    std::string_view bytes;
    std::string worker_id;
    v1::LeaseToken token;
  };
  /// Stores the bytes under their digest with the coordinator, unless it has them.
  virtual absl::Status upload(const UnitBlob& blob, std::stop_token stop) = 0;

  /// Waits before a call is tried again: for the back-off's delay, or until the coordinator is connected
  /// again. False when `stop` was requested meanwhile.
  virtual bool wait(net::Backoff& backoff, std::stop_token stop) = 0;

  const std::string& address() const { return address_; }

 private:
  const std::string address_;
};

}  // namespace tessera::agent
