// WorkService: workers.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <utility>

#include "absl/status/statusor.h"
#include "service/farm/accounts.h"
#include "service/farm/worker_origin.h"
#include "service/rpc/identities.h"
#include "tessera/v1/work.grpc.pb.h"

namespace tessera::server {

class UnitResults;
class WorkerLeases;
class WorkerRegistry;

/// The farm must outlive the service. Whatever a call makes it keep is counted on the account of the caller.
class WorkService final : public v1::WorkService::CallbackService {
 public:
  WorkService(WorkerRegistry& workers, WorkerLeases& leases, UnitResults& results,
              std::shared_ptr<Accounts> accounts)
      : workers_(workers), leases_(leases), results_(results), accounts_(std::move(accounts)) {}

  grpc::ServerUnaryReactor* Register(grpc::CallbackServerContext* context, const v1::RegisterRequest* request,
                                     v1::RegisterResponse* response) override;
  grpc::ServerUnaryReactor* Lease(grpc::CallbackServerContext* context, const v1::LeaseRequest* request,
                                  v1::LeaseResponse* response) override;
  grpc::ServerUnaryReactor* Heartbeat(grpc::CallbackServerContext* context,
                                      const v1::HeartbeatRequest* request,
                                      v1::HeartbeatResponse* response) override;
  grpc::ServerUnaryReactor* Complete(grpc::CallbackServerContext* context, const v1::CompleteRequest* request,
                                     v1::CompleteResponse* response) override;
  grpc::ServerUnaryReactor* Fail(grpc::CallbackServerContext* context, const v1::FailRequest* request,
                                 v1::FailResponse* response) override;
  grpc::ServerUnaryReactor* Deregister(grpc::CallbackServerContext* context,
                                       const v1::DeregisterRequest* request,
                                       v1::DeregisterResponse* response) override;

  WorkerOrigin origin_of(const grpc::CallbackServerContext& context);

 private:
  absl::StatusOr<std::shared_ptr<const Accounts::Hold>> take(const grpc::CallbackServerContext& context,
                                                             const Holding& amount);

  WorkerRegistry& workers_;
  WorkerLeases& leases_;
  UnitResults& results_;
  const std::shared_ptr<Accounts> accounts_;
  Identities identities_;
};

}  // namespace tessera::server
