// A connection to a coordinator of the same process, over a pair of sockets without an address.
#pragma once

#include <memory>

namespace grpc {
class Channel;
}

namespace tessera::server {

class Coordinator;

/// Calls that begin after the coordinator has shut down fail with Unavailable.
std::shared_ptr<grpc::Channel> in_process_channel(Coordinator& coordinator);

}  // namespace tessera::server
