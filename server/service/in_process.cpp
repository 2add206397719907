#include "service/in_process.h"

#include <grpcpp/create_channel_posix.h>
#include <grpcpp/server_posix.h>
#include <sys/socket.h>

#include <cerrno>
#include <system_error>

#include "net/channel.h"
#include "service/coordinator_impl.h"

namespace tessera::server {

// Not grpc::Server::InProcessChannel: with gRPC 1.51 a call that starts there once the server has shut down
// calls a null pointer (inproc_transport.cc, accept_stream_cb), and workers and clients are free to call at
// that moment. Over a pair of sockets such a call fails with Unavailable, as it does over TCP.
std::shared_ptr<grpc::Channel> in_process_channel(Coordinator& coordinator) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends) != 0) {
    throw std::system_error(errno, std::generic_category(),
                            "cannot connect to the coordinator within the process");
  }
  // Both ends belong to gRPC from here on.
  grpc::AddInsecureChannelFromFd(coordinator.impl().server.get(), ends[0]);
  return grpc::CreateCustomInsecureChannelFromFd("in-process", ends[1], net::channel_arguments());
}

}  // namespace tessera::server
