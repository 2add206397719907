// The worker's calls to the coordinator of its own process: functions, no messages.
#pragma once

#include "agent/link/coordinator_link.h"

namespace tessera::server {
class BlobStore;
class Farm;
}  // namespace tessera::server

namespace tessera::client {

class LocalLink final : public agent::CoordinatorLink {
 public:
  /// Both must outlive the link.
  LocalLink(server::Farm& farm, server::BlobStore& blobs)
      : CoordinatorLink("this process"), farm_(farm), blobs_(blobs) {}

  absl::StatusOr<v1::RegisterResponse> register_worker(const v1::RegisterRequest& request,
                                                       std::stop_token stop) override;
  absl::StatusOr<v1::LeaseResponse> lease(const v1::LeaseRequest& request, std::stop_token stop) override;
  absl::StatusOr<v1::HeartbeatResponse> heartbeat(const v1::HeartbeatRequest& request,
                                                  std::stop_token stop) override;
  absl::StatusOr<v1::CompleteResponse> complete(const v1::CompleteRequest& request,
                                                std::stop_token stop) override;
  absl::Status fail(const v1::FailRequest& request, std::stop_token stop) override;
  absl::Status deregister(const v1::DeregisterRequest& request) override;
  absl::Status download(const Wanted& wanted, const ChunkSink& sink, std::stop_token stop) override;
  absl::Status upload(const UnitBlob& blob, std::stop_token stop) override;
  bool wait(net::Backoff& backoff, std::stop_token stop) override;

 private:
  server::Farm& farm_;
  server::BlobStore& blobs_;
};

}  // namespace tessera::client
