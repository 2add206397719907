#include "service/work_service.h"

#include "service/access.h"
#include "service/answer.h"

namespace tessera::server {

grpc::ServerUnaryReactor* WorkService::Register(grpc::CallbackServerContext* context,
                                                const v1::RegisterRequest* request, v1::RegisterResponse* response) {
  const Caller caller = caller_of(context->auth_context().get());
  return answer(context->DefaultReactor(),
                farm_.register_worker(*request, {.certificate = caller.user, .peer = context->peer()}), response);
}

grpc::ServerUnaryReactor* WorkService::Lease(grpc::CallbackServerContext* context, const v1::LeaseRequest* request,
                                             v1::LeaseResponse* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  // The context lives until the answer.
  farm_.lease(
      *request, [context] { return context->IsCancelled(); },
      [reactor, response](absl::StatusOr<v1::LeaseResponse> result) { answer(reactor, std::move(result), response); });
  return reactor;
}

grpc::ServerUnaryReactor* WorkService::Heartbeat(grpc::CallbackServerContext* context,
                                                 const v1::HeartbeatRequest* request, v1::HeartbeatResponse* response) {
  return answer(context->DefaultReactor(), farm_.heartbeat(*request), response);
}

grpc::ServerUnaryReactor* WorkService::Complete(grpc::CallbackServerContext* context,
                                                const v1::CompleteRequest* request, v1::CompleteResponse* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  farm_.complete(*request, [reactor, response](absl::StatusOr<v1::CompleteResponse> result) {
    answer(reactor, std::move(result), response);
  });
  return reactor;
}

grpc::ServerUnaryReactor* WorkService::Fail(grpc::CallbackServerContext* context, const v1::FailRequest* request,
                                            v1::FailResponse* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  farm_.fail(*request, [reactor](const absl::Status& status) { answer(reactor, status); });
  return reactor;
}

grpc::ServerUnaryReactor* WorkService::Deregister(grpc::CallbackServerContext* context,
                                                  const v1::DeregisterRequest* request,
                                                  v1::DeregisterResponse* response) {
  return answer(context->DefaultReactor(), farm_.deregister(request->worker_id()));
}

}  // namespace tessera::server
