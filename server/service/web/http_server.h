// The port that browsers ask: libmicrohttpd, with bounds.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "base/clock.h"
#include "connections/connections.h"
#include "service/web/http.h"
#include "service/web/own_certificates.h"
#include "telemetry/http_daemon.h"

namespace tessera::server {

/// Bounds of connections to the page. Silent ones are those whose next request is not there whole, and those
/// of strangers. A quarter of all are kept for requests of members; on loopback all others may be of one
/// address, for that is where tunnels end.
ConnectionLimits page_limits(bool is_loopback);

struct HttpOptions {
  std::string address;       // HOST:PORT; port 0 takes a free one
  std::string certificates;  // folder of the server (net/tls.h), whose renewal is noticed; empty: no
                             // encryption
  std::optional<ConnectionLimits> limits = {};  // absent: page_limits
  std::size_t most_of_member = 32;              // connections that serve one member; more are as strangers'
  std::function<void()> renewed = [] {};        // the certificates were
  const base::Clock* clock = &base::machine_clock();  // outlives the server
};

/// Serves HTTP/1.1 from a few threads, with TLS 1.3 where it has certificates: callers may show theirs. A
/// request has to arrive whole, handshake, headers and body, within ConnectionLimits::silence.
class HttpServer {
 public:
  static constexpr unsigned kThreads = 4;
  static constexpr std::size_t kMostBody = 4096;             // bytes of a request's body
  static constexpr std::size_t kConnectionBytes = 32 << 10;  // memory for a request's line and headers
  static constexpr unsigned kTimeoutSeconds = 20;            // longest time in which nothing comes or goes

  using Handler = std::function<HttpAnswer(const HttpRequest&)>;

  /// `handle` is called from several threads. Unavailable where the address cannot be listened on;
  /// InvalidArgument for certificates that cannot be used.
  static absl::StatusOr<std::unique_ptr<HttpServer>> start(const HttpOptions& options, Handler handle);
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  int port() const;
  const Connections& connections() const { return connections_; }
  /// Closes connections that are silent for too long, and looks for new certificates; once a second, however
  /// often it is called. By one thread at a time.
  void sweep();

 private:
  struct Callbacks;  // functions that libmicrohttpd calls

  HttpServer(const HttpOptions& options, const ConnectionLimits& limits, Handler handle)
      : options_(options), handle_(std::move(handle)), connections_(limits) {}
  absl::Status read_certificates();
  MHD_Daemon* listen(const sockaddr& address, unsigned flags);
  /// A whole request of this member is being answered. Whether the connection counts as the member's; then
  /// the end of the answer is to be told.
  bool begin_answer(const Peer& peer, const std::string& member);
  void end_answer(const Peer& peer, const std::string& member);

  const HttpOptions options_;
  const Handler handle_;
  Connections connections_;
  std::mutex mutex_;
  std::map<std::string, std::size_t> served_;  // connections by member
  base::Clock::TimePoint next_sweep_{};
  OwnCertificates certificates_;
  std::string trusted_;           // authorities that libmicrohttpd was told of, in PEM
  telemetry::HttpDaemon daemon_;  // goes first, when all event streams have been closed
};

}  // namespace tessera::server
