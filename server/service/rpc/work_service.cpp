#include "service/rpc/work_service.h"

#include "service/farm/unit_results.h"
#include "service/farm/worker_leases.h"
#include "service/farm/worker_registry.h"
#include "service/rpc/access.h"
#include "service/rpc/answer.h"

namespace tessera::server {

WorkerOrigin WorkService::origin_of(const grpc::CallbackServerContext& context) {
  const std::shared_ptr<const grpc::AuthContext> caller = context.auth_context();
  return {.certificate = caller_of(caller.get()).user,
          .peer = context.peer(),
          .fingerprint = identities_.of(caller.get()),
          .account = nullptr};
}

absl::StatusOr<std::shared_ptr<const Accounts::Hold>> WorkService::take(
    const grpc::CallbackServerContext& context, const Holding& amount) {
  return accounts_->take(holder_of(caller_of(context.auth_context().get()).user, context.peer()), amount);
}

grpc::ServerUnaryReactor* WorkService::Register(grpc::CallbackServerContext* context,
                                                const v1::RegisterRequest* request,
                                                v1::RegisterResponse* response) {
  auto hold = take(*context, {.registrations = 1, .bytes = request->ByteSizeLong()});
  if (!hold.ok()) return answer(context->DefaultReactor(), hold.status());
  WorkerOrigin origin = origin_of(*context);
  origin.account = *std::move(hold);
  return answer(context->DefaultReactor(), workers_.register_worker(*request, origin), response);
}

grpc::ServerUnaryReactor* WorkService::Lease(grpc::CallbackServerContext* context,
                                             const v1::LeaseRequest* request, v1::LeaseResponse* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  auto hold = take(*context, {.calls = 1, .bytes = request->ByteSizeLong()});
  if (!hold.ok()) return answer(reactor, hold.status());
  // The context lives until the answer.
  leases_.lease(
      *request, origin_of(*context), [context] { return context->IsCancelled(); },
      [reactor, response, hold = *std::move(hold)](absl::StatusOr<v1::LeaseResponse> result) {
        answer(reactor, std::move(result), response);
      });
  return reactor;
}

grpc::ServerUnaryReactor* WorkService::Heartbeat(grpc::CallbackServerContext* context,
                                                 const v1::HeartbeatRequest* request,
                                                 v1::HeartbeatResponse* response) {
  return answer(context->DefaultReactor(), leases_.heartbeat(*request, origin_of(*context)), response);
}

grpc::ServerUnaryReactor* WorkService::Complete(grpc::CallbackServerContext* context,
                                                const v1::CompleteRequest* request,
                                                v1::CompleteResponse* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  auto hold = take(*context, {.calls = 1, .bytes = request->ByteSizeLong()});
  if (!hold.ok()) return answer(reactor, hold.status());
  results_.complete(
      *request, origin_of(*context),
      [reactor, response, hold = *std::move(hold)](absl::StatusOr<v1::CompleteResponse> result) {
        answer(reactor, std::move(result), response);
      });
  return reactor;
}

grpc::ServerUnaryReactor* WorkService::Fail(grpc::CallbackServerContext* context,
                                            const v1::FailRequest* request, v1::FailResponse* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  results_.fail(*request, origin_of(*context),
                [reactor](const absl::Status& status) { answer(reactor, status); });
  return reactor;
}

grpc::ServerUnaryReactor* WorkService::Deregister(grpc::CallbackServerContext* context,
                                                  const v1::DeregisterRequest* request,
                                                  v1::DeregisterResponse* response) {
  return answer(context->DefaultReactor(), workers_.deregister(request->worker_id(), origin_of(*context)));
}

}  // namespace tessera::server
