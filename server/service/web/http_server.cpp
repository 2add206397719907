#include "service/web/http_server.h"

#include <arpa/inet.h>
#include <gnutls/abstract.h>
#include <gnutls/gnutls.h>
#include <microhttpd.h>
#include <netdb.h>
#include <sys/socket.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include "base/address.h"
#include "net/authorities.h"
#include "net/tls.h"
#include "net/x509.h"
#include "service/web/event_stream.h"
#include "telemetry/log.h"

namespace tessera::server {
namespace {

constexpr const char* kPriorities = "SECURE128:-VERS-ALL:+VERS-TLS1.3";
constexpr std::size_t kEventBlock = 64 << 10;  // bytes of a stream that are taken at a time

/// Headers of every answer. The page runs its own scripts and nothing else, and nobody may frame it.
constexpr std::pair<const char*, const char*> kHeaders[] = {
    {"Content-Security-Policy",
     "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; "
     "manifest-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
    {"X-Content-Type-Options", "nosniff"},
    {"Referrer-Policy", "no-referrer"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Cross-Origin-Opener-Policy", "same-origin"},
};

std::string header(MHD_Connection* connection, const char* name) {
  const char* const value = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, name);
  return value == nullptr ? "" : value;
}

std::string address_of(MHD_Connection* connection) {
  const MHD_ConnectionInfo* const info =
      MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CLIENT_ADDRESS);
  char text[NI_MAXHOST] = "";
  if (info == nullptr || info->client_addr == nullptr) return text;
  const socklen_t size =
      info->client_addr->sa_family == AF_INET6 ? sizeof(sockaddr_in6) : sizeof(sockaddr_in);
  ::getnameinfo(info->client_addr, size, text, sizeof(text), nullptr, 0, NI_NUMERICHOST);
  return text;
}

gnutls_session_t session_of(MHD_Connection* connection) {
  const MHD_ConnectionInfo* const info =
      MHD_get_connection_info(connection, MHD_CONNECTION_INFO_GNUTLS_SESSION);
  return info == nullptr ? nullptr : static_cast<gnutls_session_t>(info->tls_session);
}

/// The caller's certificate, in PEM, where there is one that one of these authorities has signed and that is
/// valid.
std::string certificate_of(MHD_Connection* connection, const std::string& authorities) {
  auto* const session = session_of(connection);
  if (session == nullptr) return "";
  unsigned count = 0;
  const gnutls_datum_t* const chain = gnutls_certificate_get_peers(session, &count);
  if (chain == nullptr || count == 0) return "";
  const unsigned char* der = chain[0].data;
  const net::Certificate certificate{d2i_X509(nullptr, &der, static_cast<long>(chain[0].size))};
  // libmicrohttpd knows those authorities alone that were there when it began.
  const bool is_signed =
      certificate != nullptr && net::check_signed(authorities, certificate.get(), "caller").ok();
  return is_signed ? net::to_pem(certificate.get()) : "";
}

/// A stream that libmicrohttpd reads from.
struct OpenEvents {
  std::shared_ptr<EventStream> stream;
  MHD_Connection* connection;
};

ssize_t read_events(void* context, std::uint64_t /*position*/, char* buffer, std::size_t most) {
  auto& open = *static_cast<OpenEvents*>(context);
  MHD_Connection* const connection = open.connection;
  const std::size_t count = open.stream->take(
      buffer, most, [connection] { MHD_suspend_connection(connection); },
      [connection] { MHD_resume_connection(connection); });
  if (count > 0) return static_cast<ssize_t>(count);
  return open.stream->closed() ? ssize_t{MHD_CONTENT_READER_END_OF_STREAM} : 0;
}

void close_events(void* context) {
  const std::unique_ptr<OpenEvents> open{static_cast<OpenEvents*>(context)};
  open->stream->abandon();
}

MHD_Result reply(MHD_Connection* connection, HttpAnswer answer) {
  MHD_Response* response = nullptr;
  if (answer.events != nullptr) {
    auto open = std::make_unique<OpenEvents>(OpenEvents{std::move(answer.events), connection});
    response = MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, kEventBlock, &read_events, open.get(),
                                                 &close_events);
    if (response != nullptr) static_cast<void>(open.release());
  } else {
    response = MHD_create_response_from_buffer(answer.body.size(), answer.body.data(), MHD_RESPMEM_MUST_COPY);
  }
  if (response == nullptr) return MHD_NO;
  MHD_add_response_header(response, MHD_HTTP_HEADER_CONTENT_TYPE, answer.type.c_str());
  for (const auto& [name, value] : kHeaders) MHD_add_response_header(response, name, value);
  for (const auto& [name, value] : answer.headers)
    MHD_add_response_header(response, name.c_str(), value.c_str());
  const MHD_Result queued = MHD_queue_response(connection, answer.status, response);
  MHD_destroy_response(response);
  return queued;
}

/// A request whose body is on its way, and then its answer.
struct Arriving {
  std::string body;
  bool too_long = false;
  std::optional<std::string> member = {};  // to whom the connection counts
};

Peer peer_of(MHD_Connection* connection) {
  const MHD_ConnectionInfo* const info =
      MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CLIENT_ADDRESS);
  sockaddr_storage address{};
  if (info == nullptr || info->client_addr == nullptr) return {};
  std::memcpy(&address, info->client_addr,
              info->client_addr->sa_family == AF_INET6 ? sizeof(sockaddr_in6) : sizeof(sockaddr_in));
  return Peer::of(address);
}

constexpr std::size_t kMostConnectionsOfPage = 512, kMostOfAddress = 64;
constexpr std::chrono::seconds kSweepInterval{1};

}  // namespace

ConnectionLimits page_limits(bool is_loopback) {
  return {.all = kMostConnectionsOfPage,
          .of_address = is_loopback ? kMostConnectionsOfPage : kMostOfAddress,
          .silent = kMostConnectionsOfPage - kMostConnectionsOfPage / 4,
          .silent_of_address = is_loopback ? kMostConnectionsOfPage : kMostOfAddress / 2,
          .silence = std::chrono::seconds{30}};
}

struct HttpServer::Callbacks {
  static MHD_Result request(void* server, MHD_Connection* connection, const char* url, const char* method,
                            const char* /*version*/, const char* body, std::size_t* body_size, void** seen) {
    if (*seen == nullptr) {
      *seen = new Arriving;
      return MHD_YES;
    }
    auto& arriving = *static_cast<Arriving*>(*seen);
    if (*body_size > 0) {
      arriving.too_long |= arriving.body.size() + *body_size > kMostBody;
      if (!arriving.too_long) arriving.body.append(body, *body_size);
      *body_size = 0;
      return MHD_YES;
    }
    if (arriving.too_long)
      return reply(connection, {.status = 413, .type = "text/plain", .body = "the request is too long\n"});
    auto& page = *static_cast<HttpServer*>(server);
    HttpRequest asked = make_request(connection, url, method, std::move(arriving.body));
    asked.certificate = certificate_of(connection, page.certificates_.trusted());
    HttpAnswer answer = page.handle_(asked);
    if (answer.member && page.begin_answer(peer_of(connection), *answer.member))
      arriving.member = std::move(answer.member);
    return reply(connection, std::move(answer));
  }

  static HttpRequest make_request(MHD_Connection* connection, const char* url, const char* method,
                                  std::string body) {
    HttpRequest request{.method = method,
                        .path = url,
                        .query = {},
                        .host = header(connection, "Host"),
                        .origin = header(connection, "Origin"),
                        .fetch_site = header(connection, "Sec-Fetch-Site"),
                        .content_type = header(connection, "Content-Type"),
                        .cookie = header(connection, "Cookie"),
                        .accept_encoding = header(connection, "Accept-Encoding"),
                        .marker = header(connection, "X-Tessera"),
                        .body = std::move(body),
                        .certificate = "",
                        .peer = address_of(connection)};
    MHD_get_connection_values(
        connection, MHD_GET_ARGUMENT_KIND,
        [](void* query, MHD_ValueKind, const char* key, const char* value) {
          (*static_cast<std::map<std::string, std::string>*>(query))[key] = value == nullptr ? "" : value;
          return MHD_YES;
        },
        &request.query);
    return request;
  }

  static void completed(void* server, MHD_Connection* connection, void** seen, MHD_RequestTerminationCode) {
    const std::unique_ptr<Arriving> arriving{static_cast<Arriving*>(std::exchange(*seen, nullptr))};
    if (arriving != nullptr && arriving->member)
      static_cast<HttpServer*>(server)->end_answer(peer_of(connection), *arriving->member);
  }

  /// A connection began, or is over.
  static void connected(void* server, MHD_Connection* connection, void** page,
                        MHD_ConnectionNotificationCode code) {
    if (code != MHD_CONNECTION_NOTIFY_STARTED) return;
    *page = server;
    auto& self = *static_cast<HttpServer*>(server);
    // Browsers offer certificates of the authorities that are named; where those are others now, of any.
    if (auto* const session = session_of(connection);
        session != nullptr && self.certificates_.trusted() != self.trusted_) {
      gnutls_certificate_send_x509_rdn_sequence(session, 1);
    }
    const MHD_ConnectionInfo* const info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    if (info == nullptr) return;
    const int descriptor = info->connect_fd;
    if (!self.connections_.admit(descriptor, peer_of(connection), Connections::Port::kBrowsers,
                                 self.options_.clock->now())) {
      ::shutdown(descriptor, SHUT_RDWR);
    }
  }

  /// Says which certificate to show in a handshake.
  static int certificate(gnutls_session_t session, const gnutls_datum_t*, int, const gnutls_pk_algorithm_t*,
                         int, gnutls_pcert_st** chain, unsigned* length, gnutls_privkey_t* key) {
    auto* const connection = static_cast<MHD_Connection*>(gnutls_session_get_ptr(session));
    const MHD_ConnectionInfo* const info =
        connection == nullptr ? nullptr
                              : MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
    if (info == nullptr || info->socket_context == nullptr) return -1;
    const OwnCertificates::Shown shown =
        static_cast<HttpServer*>(info->socket_context)->certificates_.shown();
    *chain = shown.chain;
    *length = shown.length;
    *key = shown.key;
    return 0;
  }
};

bool HttpServer::begin_answer(const Peer& peer, const std::string& member) {
  {
    const std::lock_guard lock(mutex_);
    std::size_t& count = served_[member];
    if (!member.empty() && count >= options_.most_of_member) return false;
    ++count;
  }
  connections_.spoke(peer);
  return true;
}

void HttpServer::end_answer(const Peer& peer, const std::string& member) {
  connections_.fell_silent(peer, options_.clock->now());
  const std::lock_guard lock(mutex_);
  if (const auto served = served_.find(member); --served->second == 0) served_.erase(served);
}

void HttpServer::sweep() {
  const base::Clock::TimePoint now = options_.clock->now();
  if (now < next_sweep_) return;
  next_sweep_ = now + kSweepInterval;
  connections_.sweep(now);
  if (options_.certificates.empty() || !certificates_.has_news(options_.certificates)) return;
  if (absl::Status status = certificates_.read(options_.certificates); !status.ok()) {
    // Files are replaced one after the other.
    spdlog::warn("the web page keeps its certificate: {}", std::string(status.message()));
    return;
  }
  spdlog::info("the web page shows a new certificate");
  options_.renewed();
}

absl::Status HttpServer::read_certificates() {
  if (options_.certificates.empty()) return absl::OkStatus();
  if (MHD_is_feature_supported(MHD_FEATURE_TLS) != MHD_YES)
    return absl::UnavailableError("this system's libmicrohttpd cannot encrypt: --web off");
  absl::Status status = certificates_.read(options_.certificates);
  trusted_ = certificates_.trusted();
  return status;
}

absl::StatusOr<std::unique_ptr<HttpServer>> HttpServer::start(const HttpOptions& options, Handler handle) {
  const absl::StatusOr<base::HostPort> parsed = base::parse_host_port(options.address);
  if (!parsed.ok()) return parsed.status();
  const ConnectionLimits limits = options.limits.value_or(page_limits(base::is_loopback(parsed->host)));
  std::unique_ptr<HttpServer> server{new HttpServer{options, limits, std::move(handle)}};
  if (absl::Status s = server->read_certificates(); !s.ok()) return s;
  absl::StatusOr<telemetry::HttpDaemon> daemon = telemetry::listen_http(
      options.address, "the web page",
      [&](const sockaddr& address, unsigned flags) { return server->listen(address, flags); });
  if (!daemon.ok()) return daemon.status();
  server->daemon_ = *std::move(daemon);
  return server;
}

MHD_Daemon* HttpServer::listen(const sockaddr& address, unsigned flags) {
  flags |= MHD_USE_EPOLL_INTERNAL_THREAD | MHD_ALLOW_SUSPEND_RESUME;
  // Each thread has its part of libmicrohttpd's own limit, and beyond it accepts nobody. Any of them may have
  // to take all connections, and those that were shut and not closed yet.
  const auto most = static_cast<unsigned>(connections_.limits().all);
  std::vector<MHD_OptionItem> items = {
      {MHD_OPTION_THREAD_POOL_SIZE, kThreads, nullptr},
      {MHD_OPTION_CONNECTION_LIMIT, 2 * kThreads * most, nullptr},
      {MHD_OPTION_CONNECTION_TIMEOUT, kTimeoutSeconds, nullptr},
      {MHD_OPTION_CONNECTION_MEMORY_LIMIT, kConnectionBytes, nullptr},
  };
  if (!options_.certificates.empty()) {
    flags |= MHD_USE_TLS;
    items.push_back({MHD_OPTION_HTTPS_CERT_CALLBACK, 0, reinterpret_cast<void*>(&Callbacks::certificate)});
    items.push_back({MHD_OPTION_HTTPS_MEM_TRUST, 0, trusted_.data()});
    items.push_back({MHD_OPTION_HTTPS_PRIORITIES, 0, const_cast<char*>(kPriorities)});
  }
  items.push_back({MHD_OPTION_END, 0, nullptr});
  return MHD_start_daemon(flags, 0, nullptr, nullptr, &Callbacks::request, this,      //
                          MHD_OPTION_SOCK_ADDR, &address,                             //
                          MHD_OPTION_NOTIFY_COMPLETED, &Callbacks::completed, this,   //
                          MHD_OPTION_NOTIFY_CONNECTION, &Callbacks::connected, this,  //
                          MHD_OPTION_ARRAY, items.data(), MHD_OPTION_END);
}

int HttpServer::port() const { return telemetry::port_of(daemon_.get()); }

}  // namespace tessera::server
