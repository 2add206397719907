#include "telemetry/http_daemon.h"

#include <microhttpd.h>
#include <netdb.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "base/address.h"

namespace tessera::telemetry {

void StopHttpDaemon::operator()(MHD_Daemon* daemon) const { MHD_stop_daemon(daemon); }

absl::StatusOr<HttpDaemon> listen_http(const std::string& address, const std::string& what,
                                       const StartHttpDaemon& start) {
  const absl::StatusOr<base::HostPort> parsed = base::parse_host_port(address);
  if (!parsed.ok()) return parsed.status();
  const auto cannot = [&](const char* why) {
    return absl::UnavailableError(absl::StrCat("cannot serve ", what, " on ", address, ": ", why));
  };
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const std::string port = std::to_string(parsed->port);
  if (const int error = ::getaddrinfo(parsed->host.c_str(), port.c_str(), &hints, &found); error != 0)
    return cannot(::gai_strerror(error));
  errno = EADDRNOTAVAIL;
  HttpDaemon daemon;
  for (const addrinfo* at = found; at != nullptr && !daemon; at = at->ai_next)
    daemon.reset(start(*at->ai_addr, at->ai_family == AF_INET6 ? unsigned{MHD_USE_IPv6} : 0));
  const int error = errno;
  ::freeaddrinfo(found);
  if (!daemon) return cannot(std::strerror(error));
  return daemon;
}

int port_of(MHD_Daemon* daemon) {
  const MHD_DaemonInfo* const info = MHD_get_daemon_info(daemon, MHD_DAEMON_INFO_BIND_PORT);
  return info == nullptr ? 0 : info->port;
}

}  // namespace tessera::telemetry
