#include "service/rpc/health_server.h"

#include <grpcpp/health_check_service_interface.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "base/address.h"

namespace tessera::server {

absl::StatusOr<std::unique_ptr<HealthServer>> HealthServer::start(const std::string& address,
                                                                  Connections& connections) {
  const absl::StatusOr<base::HostPort> parsed = base::parse_host_port(address);
  if (!parsed.ok()) return parsed.status();
  auto health = std::unique_ptr<HealthServer>(new HealthServer);
  grpc::EnableDefaultHealthCheckService(true);
  grpc::ServerBuilder builder;
  auto listener = Listener::open(*parsed, connections, Connections::Port::kStrangers);
  if (!listener.ok()) {
    return absl::UnavailableError(absl::StrCat("health: ", std::string(listener.status().message())));
  }
  health->listener_ = *std::move(listener);
  Listener::Acceptor acceptor = builder.experimental().AddExternalConnectionAcceptor(
      grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD,
      grpc::InsecureServerCredentials());
  health->server_ = builder.BuildAndStart();
  if (health->server_ == nullptr) return absl::InternalError("gRPC does not start a server");
  health->set_serving(false);
  health->listener_->start(std::move(acceptor));
  return health;
}

HealthServer::~HealthServer() {
  if (listener_ != nullptr) listener_->stop();
  if (server_ != nullptr) server_->Shutdown(std::chrono::system_clock::now());
}

void HealthServer::set_serving(bool serving) { server_->GetHealthCheckService()->SetServingStatus(serving); }

}  // namespace tessera::server
