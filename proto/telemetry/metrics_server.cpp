#include "telemetry/metrics_server.h"

#include <microhttpd.h>
#include <netdb.h>
#include <prometheus/text_serializer.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <iterator>
#include <sstream>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "base/address.h"

namespace tessera::telemetry {
namespace {

constexpr unsigned kTimeoutSeconds = 10;
constexpr std::size_t kConnectionBytes = 16 << 10;  // for a request's headers, and for the answer's
// Others are told to close, which the daemon does a moment later.
constexpr std::size_t kMostOpen = MetricsServer::kMostConnections / 2;

void shut_down(MHD_Connection* connection) {
  const MHD_ConnectionInfo* const info =
      MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
  if (info != nullptr) ::shutdown(info->connect_fd, SHUT_RDWR);
}

MHD_Result answer(MHD_Connection* connection, unsigned code, std::string text, const char* type) {
  MHD_Response* const response =
      MHD_create_response_from_buffer(text.size(), text.data(), MHD_RESPMEM_MUST_COPY);
  if (response == nullptr) return MHD_NO;
  MHD_add_response_header(response, MHD_HTTP_HEADER_CONTENT_TYPE, type);
  const MHD_Result queued = MHD_queue_response(connection, code, response);
  MHD_destroy_response(response);
  return queued;
}

}  // namespace

struct MetricsServer::Callbacks {
  static MHD_Result request(void* server, MHD_Connection* connection, const char* url, const char* method,
                            const char* /*version*/, const char* /*body*/, std::size_t* body_size,
                            void** seen) {
    // The first call is for the headers; the answer comes with the second one, behind a body.
    if (std::exchange(*seen, server) == nullptr) return MHD_YES;
    *body_size = 0;
    if (std::string_view{url} != "/metrics")
      return answer(connection, MHD_HTTP_NOT_FOUND, "see /metrics\n", "text/plain");
    const std::string_view wanted{method};
    if (wanted != MHD_HTTP_METHOD_GET && wanted != MHD_HTTP_METHOD_HEAD) {
      return answer(connection, MHD_HTTP_METHOD_NOT_ALLOWED, "GET only\n", "text/plain");
    }
    return answer(connection, MHD_HTTP_OK, static_cast<MetricsServer*>(server)->text(),
                  "text/plain; version=0.0.4; charset=utf-8");
  }

  static void connection(void* server, MHD_Connection* connection, void** /*context*/,
                         MHD_ConnectionNotificationCode what) {
    auto& self = *static_cast<MetricsServer*>(server);
    what == MHD_CONNECTION_NOTIFY_STARTED ? self.opened(connection)
                                          : static_cast<void>(self.connections_.remove(connection));
  }
};

absl::StatusOr<std::unique_ptr<MetricsServer>> MetricsServer::start(
    const std::string& address, std::vector<std::shared_ptr<prometheus::Collectable>> sources) {
  const absl::StatusOr<base::HostPort> parsed = base::parse_host_port(address);
  if (!parsed.ok()) return parsed.status();
  std::unique_ptr<MetricsServer> server{new MetricsServer};
  server->sources_ = std::move(sources);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (const int error =
          ::getaddrinfo(parsed->host.c_str(), std::to_string(parsed->port).c_str(), &hints, &found);
      error != 0) {
    return absl::UnavailableError(
        absl::StrCat("cannot serve metrics on ", address, ": ", ::gai_strerror(error)));
  }
  errno = EADDRNOTAVAIL;
  bool listens = false;
  for (const addrinfo* at = found; at != nullptr && !listens; at = at->ai_next)
    listens = server->listen(*at->ai_addr);
  const int error = errno;
  ::freeaddrinfo(found);
  if (listens) return server;
  return absl::UnavailableError(
      absl::StrCat("cannot serve metrics on ", address, ": ", std::strerror(error)));
}

bool MetricsServer::listen(const sockaddr& address) {
  unsigned flags = MHD_USE_EPOLL_INTERNAL_THREAD;
  if (address.sa_family == AF_INET6) flags |= MHD_USE_IPv6;
  daemon_ = MHD_start_daemon(flags, 0, nullptr, nullptr, &Callbacks::request, this,       //
                             MHD_OPTION_SOCK_ADDR, &address,                              //
                             MHD_OPTION_NOTIFY_CONNECTION, &Callbacks::connection, this,  //
                             MHD_OPTION_CONNECTION_LIMIT, unsigned{kMostConnections},     //
                             MHD_OPTION_CONNECTION_TIMEOUT, kTimeoutSeconds,              //
                             MHD_OPTION_CONNECTION_MEMORY_LIMIT, kConnectionBytes, MHD_OPTION_END);
  return daemon_ != nullptr;
}

MetricsServer::~MetricsServer() {
  if (daemon_ != nullptr) MHD_stop_daemon(daemon_);
}

int MetricsServer::port() const {
  const MHD_DaemonInfo* const info = MHD_get_daemon_info(daemon_, MHD_DAEMON_INFO_BIND_PORT);
  return info == nullptr ? 0 : info->port;
}

std::string MetricsServer::text() const {
  std::vector<prometheus::MetricFamily> families;
  for (const auto& source : sources_) {
    std::vector<prometheus::MetricFamily> more = source->Collect();
    families.insert(families.end(), std::move_iterator{more.begin()}, std::move_iterator{more.end()});
  }
  std::ostringstream out;
  prometheus::TextSerializer{}.Serialize(out, families);
  return std::move(out).str();
}

void MetricsServer::opened(MHD_Connection* connection) {
  connections_.push_back(connection);
  // Those that were told to close are still the first ones.
  if (connections_.size() <= kMostOpen) return;
  shut_down(
      *std::next(connections_.begin(), static_cast<std::ptrdiff_t>(connections_.size() - kMostOpen - 1)));
}

}  // namespace tessera::telemetry
