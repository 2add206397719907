// A port of HTTP, by libmicrohttpd.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "absl/status/statusor.h"

struct MHD_Daemon;
struct sockaddr;

namespace tessera::telemetry {

struct StopHttpDaemon {
  void operator()(MHD_Daemon* daemon) const;
};
/// Stops when it goes, once all of its answers are over.
using HttpDaemon = std::unique_ptr<MHD_Daemon, StopHttpDaemon>;

/// Starts a daemon that listens on an address; `flags` are those that the address wants. Null, with errno
/// set, where that does not work.
using StartHttpDaemon = std::function<MHD_Daemon*(const sockaddr& address, unsigned flags)>;

/// A daemon on the first address of HOST:PORT that can be listened on; port 0 takes a free one.
/// InvalidArgument where `address` is none; Unavailable where none of its addresses can be listened on:
/// "cannot serve WHAT on ADDRESS: reason".
absl::StatusOr<HttpDaemon> listen_http(const std::string& address, const std::string& what,
                                       const StartHttpDaemon& start);

/// The port that it listens on.
int port_of(MHD_Daemon* daemon);

}  // namespace tessera::telemetry
