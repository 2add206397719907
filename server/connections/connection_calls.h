// Tells Connections on which of them calls come.
#pragma once

#include <grpcpp/support/server_interceptor.h>

#include <memory>

#include "connections/connections.h"

namespace tessera::server {

/// For grpc::ServerBuilder. The connections must outlive the server.
std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> notice_calls(Connections& connections);

}  // namespace tessera::server
