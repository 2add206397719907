#include "telemetry/metrics_server.h"

#include <microhttpd.h>
#include <prometheus/text_serializer.h>
#include <sys/socket.h>

#include <iterator>
#include <sstream>
#include <string_view>
#include <utility>

namespace tessera::telemetry {
namespace {

constexpr unsigned kTimeoutSeconds = 10;
constexpr std::size_t kConnectionBytes = 16 << 10;  // room for a request's headers, and for the answer's
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
  std::unique_ptr<MetricsServer> server{new MetricsServer};
  server->sources_ = std::move(sources);
  const auto start = [self = server.get()](const sockaddr& place, unsigned flags) {
    return MHD_start_daemon(MHD_USE_EPOLL_INTERNAL_THREAD | flags, 0, nullptr, nullptr, &Callbacks::request,
                            self,                                                        //
                            MHD_OPTION_SOCK_ADDR, &place,                                //
                            MHD_OPTION_NOTIFY_CONNECTION, &Callbacks::connection, self,  //
                            MHD_OPTION_CONNECTION_LIMIT, unsigned{kMostConnections},     //
                            MHD_OPTION_CONNECTION_TIMEOUT, kTimeoutSeconds,              //
                            MHD_OPTION_CONNECTION_MEMORY_LIMIT, kConnectionBytes, MHD_OPTION_END);
  };
  absl::StatusOr<HttpDaemon> daemon = listen_http(address, "metrics", start);
  if (!daemon.ok()) return daemon.status();
  server->daemon_ = *std::move(daemon);
  return server;
}

int MetricsServer::port() const { return port_of(daemon_.get()); }

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
  // Connections that were told to close are still the first ones.
  if (connections_.size() <= kMostOpen) return;
  shut_down(
      *std::next(connections_.begin(), static_cast<std::ptrdiff_t>(connections_.size() - kMostOpen - 1)));
}

}  // namespace tessera::telemetry
