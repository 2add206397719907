#include "service/health_server.h"

#include <grpcpp/health_check_service_interface.h>

#include "absl/strings/str_cat.h"
#include "wire/address.h"

namespace tessera::server {

absl::StatusOr<std::unique_ptr<HealthServer>> HealthServer::start(const std::string& address) {
  const absl::StatusOr<wire::HostPort> parsed = wire::parse_host_port(address);
  if (!parsed.ok()) return parsed.status();
  auto health = std::unique_ptr<HealthServer>(new HealthServer);
  grpc::EnableDefaultHealthCheckService(true);
  grpc::ServerBuilder builder;
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  builder.AddListeningPort(parsed->to_string(), grpc::InsecureServerCredentials(), &health->port_);
  health->server_ = builder.BuildAndStart();
  if (health->server_ == nullptr || health->port_ == 0) {
    return absl::UnavailableError(
        absl::StrCat("cannot serve health on ", address, ": in use, or not an address of this machine"));
  }
  health->set_serving(false);
  return health;
}

HealthServer::~HealthServer() {
  if (server_ != nullptr) server_->Shutdown(std::chrono::system_clock::now());
}

void HealthServer::set_serving(bool serving) { server_->GetHealthCheckService()->SetServingStatus(serving); }

}  // namespace tessera::server
