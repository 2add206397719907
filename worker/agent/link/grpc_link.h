// The worker's calls over gRPC.
#pragma once

#include <memory>
#include <string>

#include "agent/link/coordinator_link.h"

namespace grpc {
class Channel;
}

namespace tessera::agent {

/// A deadline on each call, errors that name the RPC and the address.
class GrpcLink final : public CoordinatorLink {
 public:
  GrpcLink(std::shared_ptr<grpc::Channel> channel, std::string address);
  ~GrpcLink() override;

  absl::StatusOr<v1::RegisterResponse> register_worker(const v1::RegisterRequest& request,
                                                       std::stop_token stop) override;
  /// The deadline is the request's `max_wait` and a margin.
  absl::StatusOr<v1::LeaseResponse> lease(const v1::LeaseRequest& request, std::stop_token stop) override;
  absl::StatusOr<v1::HeartbeatResponse> heartbeat(const v1::HeartbeatRequest& request,
                                                  std::stop_token stop) override;
  absl::StatusOr<v1::CompleteResponse> complete(const v1::CompleteRequest& request,
                                                std::stop_token stop) override;
  absl::Status fail(const v1::FailRequest& request, std::stop_token stop) override;
  absl::Status deregister(const v1::DeregisterRequest& request) override;
  /// DeadlineExceeded when no chunk has come for 30 s.
  absl::Status download(const Wanted& wanted, const ChunkSink& sink, std::stop_token stop) override;
  /// Like net::upload_rest.
  absl::Status upload(const UnitBlob& blob, std::stop_token stop) override;
  bool wait(net::Backoff& backoff, std::stop_token stop) override;

 private:
  struct Stubs;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<Stubs> stubs_;
};

}  // namespace tessera::agent
