#include "service/in_process.h"

#include "service/coordinator_impl.h"
#include "wire/channel.h"

namespace tessera::server {

std::shared_ptr<grpc::Channel> in_process_channel(Coordinator& coordinator) {
  return coordinator.impl().server->InProcessChannel(wire::channel_arguments());
}

}  // namespace tessera::server
