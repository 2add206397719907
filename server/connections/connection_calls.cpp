#include "connections/connection_calls.h"

#include <grpcpp/server_context.h>

namespace tessera::server {
namespace {

using grpc::experimental::InterceptionHookPoints;

class NoticeCall final : public grpc::experimental::Interceptor {
 public:
  NoticeCall(Connections& connections, grpc::experimental::ServerRpcInfo* call)
      : connections_(connections), call_(call) {}

  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override {
    if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::POST_RECV_INITIAL_METADATA)) {
      connections_.spoke(Peer::of(call_->server_context()->peer()));
    }
    methods->Proceed();
  }

 private:
  Connections& connections_;
  grpc::experimental::ServerRpcInfo* const call_;
};

class NoticeCalls final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  explicit NoticeCalls(Connections& connections) : connections_(connections) {}

  grpc::experimental::Interceptor* CreateServerInterceptor(grpc::experimental::ServerRpcInfo* call) override {
    return new NoticeCall{connections_, call};  // gRPC's from here on
  }

 private:
  Connections& connections_;
};

}  // namespace

std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> notice_calls(
    Connections& connections) {
  return std::make_unique<NoticeCalls>(connections);
}

}  // namespace tessera::server
