#include "service/web/http_server.h"

#include <arpa/inet.h>
#include <gnutls/gnutls.h>
#include <microhttpd.h>
#include <netdb.h>
#include <sys/socket.h>

#include <fstream>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include "base/address.h"
#include "service/web/event_stream.h"
#include "transport/tls.h"
#include "transport/x509.h"

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

std::string file_contents(const std::filesystem::path& path) {
  std::ifstream in{path, std::ios::binary};
  return {std::istreambuf_iterator<char>(in), {}};
}

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

/// The caller's certificate, in PEM, where there is one that the farm's authority has signed and that is
/// valid.
std::string certificate_of(MHD_Connection* connection) {
  const MHD_ConnectionInfo* const info =
      MHD_get_connection_info(connection, MHD_CONNECTION_INFO_GNUTLS_SESSION);
  if (info == nullptr || info->tls_session == nullptr) return "";
  auto* const session = static_cast<gnutls_session_t>(info->tls_session);
  unsigned count = 0, problems = 0;
  const gnutls_datum_t* const chain = gnutls_certificate_get_peers(session, &count);
  if (chain == nullptr || count == 0) return "";
  if (gnutls_certificate_verify_peers2(session, &problems) != 0 || problems != 0) return "";
  const unsigned char* der = chain[0].data;
  const transport::Certificate certificate{d2i_X509(nullptr, &der, static_cast<long>(chain[0].size))};
  return certificate == nullptr ? "" : transport::to_pem(certificate.get());
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

/// A request whose body is on its way.
struct Arriving {
  std::string body;
  bool too_long = false;
};

}  // namespace

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
    return reply(connection, static_cast<HttpServer*>(server)->handle_(
                                 make_request(connection, url, method, std::move(arriving.body))));
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
                        .certificate = certificate_of(connection),
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

  static void completed(void* /*server*/, MHD_Connection*, void** seen, MHD_RequestTerminationCode) {
    delete static_cast<Arriving*>(std::exchange(*seen, nullptr));
  }
};

absl::Status HttpServer::read_certificates() {
  if (options_.certificates.empty()) return absl::OkStatus();
  if (MHD_is_feature_supported(MHD_FEATURE_TLS) != MHD_YES)
    return absl::UnavailableError("this system's libmicrohttpd cannot encrypt: --web off");
  if (absl::Status s = transport::check_certificates(options_.certificates); !s.ok()) return s;
  const std::filesystem::path folder = options_.certificates;
  key_ = file_contents(folder / transport::kKeyFile);
  certificate_ = file_contents(folder / transport::kCertificateFile);
  trusted_ = file_contents(folder / transport::kTrustedFile);
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<HttpServer>> HttpServer::start(const HttpOptions& options, Handler handle) {
  const absl::StatusOr<base::HostPort> parsed = base::parse_host_port(options.address);
  if (!parsed.ok()) return parsed.status();
  std::unique_ptr<HttpServer> server{new HttpServer{options, std::move(handle)}};
  if (absl::Status s = server->read_certificates(); !s.ok()) return s;
  const unsigned most_of_address = base::is_loopback(parsed->host) ? kMostConnections : kMostOfAddress;
  absl::StatusOr<telemetry::HttpDaemon> daemon =
      telemetry::listen_http(options.address, "the web page", [&](const sockaddr& address, unsigned flags) {
        return server->listen(address, flags, most_of_address);
      });
  if (!daemon.ok()) return daemon.status();
  server->daemon_ = *std::move(daemon);
  return server;
}

MHD_Daemon* HttpServer::listen(const sockaddr& address, unsigned flags, unsigned most_of_address) {
  flags |= MHD_USE_EPOLL_INTERNAL_THREAD | MHD_ALLOW_SUSPEND_RESUME;
  std::vector<MHD_OptionItem> items = {
      {MHD_OPTION_THREAD_POOL_SIZE, kThreads, nullptr},
      {MHD_OPTION_CONNECTION_LIMIT, kMostConnections, nullptr},
      {MHD_OPTION_PER_IP_CONNECTION_LIMIT, most_of_address, nullptr},
      {MHD_OPTION_CONNECTION_TIMEOUT, kTimeoutSeconds, nullptr},
      {MHD_OPTION_CONNECTION_MEMORY_LIMIT, kConnectionBytes, nullptr},
  };
  if (!options_.certificates.empty()) {
    flags |= MHD_USE_TLS;
    items.push_back({MHD_OPTION_HTTPS_MEM_KEY, 0, key_.data()});
    items.push_back({MHD_OPTION_HTTPS_MEM_CERT, 0, certificate_.data()});
    items.push_back({MHD_OPTION_HTTPS_MEM_TRUST, 0, trusted_.data()});
    items.push_back({MHD_OPTION_HTTPS_PRIORITIES, 0, const_cast<char*>(kPriorities)});
  }
  items.push_back({MHD_OPTION_END, 0, nullptr});
  return MHD_start_daemon(flags, 0, nullptr, nullptr, &Callbacks::request, this,        //
                          MHD_OPTION_SOCK_ADDR, &address,                               //
                          MHD_OPTION_NOTIFY_COMPLETED, &Callbacks::completed, nullptr,  //
                          MHD_OPTION_ARRAY, items.data(), MHD_OPTION_END);
}

int HttpServer::port() const { return telemetry::port_of(daemon_.get()); }

}  // namespace tessera::server
