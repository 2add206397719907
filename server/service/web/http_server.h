// The port that browsers ask: libmicrohttpd, with bounds.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "service/web/http.h"
#include "telemetry/http_daemon.h"

namespace tessera::server {

struct HttpOptions {
  std::string address;       // HOST:PORT; port 0 takes a free one
  std::string certificates;  // folder of the server (transport/tls.h); empty: no encryption
};

/// Serves HTTP/1.1 from a few threads, with TLS 1.3 where it has certificates: callers may show theirs.
class HttpServer {
 public:
  /// On loopback all may be of one address: that is where tunnels end.
  static constexpr unsigned kMostConnections = 512, kMostOfAddress = 64;
  static constexpr unsigned kThreads = 4;
  static constexpr std::size_t kMostBody = 4096;             // bytes of a request's body
  static constexpr std::size_t kConnectionBytes = 32 << 10;  // for a request's line and headers
  static constexpr unsigned kTimeoutSeconds = 30;

  using Handler = std::function<HttpAnswer(const HttpRequest&)>;

  /// `handle` is called from several threads. Unavailable where the address cannot be listened on;
  /// InvalidArgument for certificates that cannot be used.
  static absl::StatusOr<std::unique_ptr<HttpServer>> start(const HttpOptions& options, Handler handle);
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  int port() const;

 private:
  struct Callbacks;  // of libmicrohttpd

  HttpServer(const HttpOptions& options, Handler handle) : options_(options), handle_(std::move(handle)) {}
  absl::Status read_certificates();
  MHD_Daemon* listen(const sockaddr& address, unsigned flags, unsigned most_of_address);

  const HttpOptions options_;
  const Handler handle_;
  std::string key_, certificate_, trusted_;  // PEM
  telemetry::HttpDaemon daemon_;             // goes first, when all event streams have been closed
};

}  // namespace tessera::server
