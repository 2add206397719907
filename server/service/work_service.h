// WorkService: workers.
#pragma once

#include <grpcpp/grpcpp.h>

#include "service/farm.h"
#include "service/identities.h"
#include "tessera/v1/work.grpc.pb.h"

namespace tessera::server {

/// The farm must outlive the service.
class WorkService final : public v1::WorkService::CallbackService {
 public:
  explicit WorkService(Farm& farm) : farm_(farm) {}

  grpc::ServerUnaryReactor* Register(grpc::CallbackServerContext* context, const v1::RegisterRequest* request,
                                     v1::RegisterResponse* response) override;
  grpc::ServerUnaryReactor* Lease(grpc::CallbackServerContext* context, const v1::LeaseRequest* request,
                                  v1::LeaseResponse* response) override;
  grpc::ServerUnaryReactor* Heartbeat(grpc::CallbackServerContext* context, const v1::HeartbeatRequest* request,
                                      v1::HeartbeatResponse* response) override;
  grpc::ServerUnaryReactor* Complete(grpc::CallbackServerContext* context, const v1::CompleteRequest* request,
                                     v1::CompleteResponse* response) override;
  grpc::ServerUnaryReactor* Fail(grpc::CallbackServerContext* context, const v1::FailRequest* request,
                                 v1::FailResponse* response) override;
  grpc::ServerUnaryReactor* Deregister(grpc::CallbackServerContext* context, const v1::DeregisterRequest* request,
                                       v1::DeregisterResponse* response) override;

 private:
  Farm::Origin origin_of(const grpc::CallbackServerContext& context);

  Farm& farm_;
  Identities identities_;
};

}  // namespace tessera::server
