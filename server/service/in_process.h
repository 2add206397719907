// A connection to a coordinator of the same process, without a socket.
#pragma once

#include <memory>

namespace grpc {
class Channel;
}

namespace tessera::server {

class Coordinator;

/// The coordinator must outlive all calls on the channel.
std::shared_ptr<grpc::Channel> in_process_channel(Coordinator& coordinator);

}  // namespace tessera::server
