// Connections to a coordinator.
#pragma once

#include <chrono>
#include <memory>
#include <stop_token>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace grpc {
class Channel;
class ChannelArguments;
}  // namespace grpc

namespace tessera::net {

struct ChannelOptions {
  bool allow_insecure = false;    // talk without encryption to an address that is not loopback
  std::string certificates = {};  // folder of net/tls.h; empty: no encryption
};

/// A channel to `address` (HOST:PORT). Nothing is connected yet: the first call does that, and a lost
/// connection is made anew, with a back-off of at most 1 s. InvalidArgument for a malformed address;
/// PermissionDenied for one that is not loopback, unless allowed, without certificates; what
/// check_certificates() says of those.
absl::StatusOr<std::shared_ptr<grpc::Channel>> make_channel(std::string_view address,
                                                            const ChannelOptions& options = {});

/// Sleeps for `delay`; where the channel is not connected, only until it is. False when `stop` was requested
/// meanwhile. Whoever waits between two tries of a call waits here: gRPC looks after a connection that is
/// being made while calls are under way, and otherwise every five seconds only.
bool wait_for_connection(grpc::Channel& channel, std::chrono::milliseconds delay, std::stop_token stop);

/// Message caps and keepalive of every channel, for channels that are made elsewhere (in one process).
grpc::ChannelArguments channel_arguments();

}  // namespace tessera::net
