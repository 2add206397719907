#include "connections/listener.h"

#include <fcntl.h>
#include <grpcpp/server_builder.h>
#include <netdb.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"
#include "connections/free_memory.h"
#include "telemetry/log.h"

namespace tessera::server {
namespace {

using std::chrono::milliseconds;
using Clock = Connections::Clock;

constexpr int kBacklog = 4096;   // the system's own limit may be less
constexpr int kMostAtOnce = 64;  // connections accepted before the clock is looked at again
constexpr milliseconds kSweepInterval{1000};
constexpr std::uint64_t kSweepsPerTrim = 4;
constexpr milliseconds kPause{100};         // after an error that may pass
constexpr unsigned kUserTimeoutMs = 5'000;  // as gRPC's own listeners: for bytes that nobody acknowledges

struct FreeAddresses {
  void operator()(addrinfo* addresses) const { ::freeaddrinfo(addresses); }
};
using Addresses = std::unique_ptr<addrinfo, FreeAddresses>;

/// Every address that the name stands for. All of the machine's are one of both families where there is IPv6.
Addresses resolve(const std::string& host, int port) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  return Addresses{::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found) == 0 ? found
                                                                                                  : nullptr};
}

int port_of(int socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
  return Peer::of(address).port;
}

void set_option(int socket, int level, int name, int value) {
  ::setsockopt(socket, level, name, &value, sizeof(value));
}

/// A socket that listens there; -1, with errno.
int listen_on(const sockaddr* address, socklen_t size) {
  const int socket = ::socket(address->sa_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket < 0) return -1;
  set_option(socket, SOL_SOCKET, SO_REUSEADDR, 1);
  // Both are inherited by what is accepted.
  set_option(socket, IPPROTO_TCP, TCP_NODELAY, 1);
  set_option(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, static_cast<int>(kUserTimeoutMs));
  if (address->sa_family == AF_INET6) set_option(socket, IPPROTO_IPV6, IPV6_V6ONLY, 0);
  if (::bind(socket, address, size) == 0 && ::listen(socket, kBacklog) == 0) return socket;
  const int error = errno;
  ::close(socket);
  errno = error;
  return -1;
}

/// Nothing of it waits in the system afterwards.
void refuse(int connection) {
  const linger at_once{.l_onoff = 1, .l_linger = 0};
  ::setsockopt(connection, SOL_SOCKET, SO_LINGER, &at_once, sizeof(at_once));
  ::close(connection);
}

int open_spare() { return ::open("/dev/null", O_RDONLY | O_CLOEXEC); }

}  // namespace

Listener::Listener(base::HostPort address, Connections& connections, Connections::Port kind)
    : address_(std::move(address)),
      connections_(connections),
      kind_(kind),
      wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      spare_(open_spare()) {}

absl::StatusOr<std::unique_ptr<Listener>> Listener::open(const base::HostPort& address,
                                                         Connections& connections, Connections::Port kind) {
  std::unique_ptr<Listener> listener{new Listener{address, connections, kind}};
  if (absl::Status status = listener->listen(); !status.ok()) return status;
  return listener;
}

Listener::~Listener() {
  stop();
  if (wake_ >= 0) ::close(wake_);
  if (spare_ >= 0) ::close(spare_);
}

absl::Status Listener::listen() {
  const std::string name = address_.to_string();
  // Whoever asks for all addresses of this machine gets those of IPv6 too, as from gRPC.
  const bool everywhere = address_.host == "0.0.0.0" || address_.host == "::";
  Addresses addresses = resolve(everywhere ? "::" : address_.host, address_.port);
  const auto listen_on_all = [&] {
    for (const addrinfo* at = addresses.get(); at != nullptr; at = at->ai_next) {
      // The port that the first one took.
      if (at->ai_family == AF_INET)
        reinterpret_cast<sockaddr_in*>(at->ai_addr)->sin_port = htons(address_.port);
      if (at->ai_family == AF_INET6)
        reinterpret_cast<sockaddr_in6*>(at->ai_addr)->sin6_port = htons(address_.port);
      const int socket = listen_on(at->ai_addr, at->ai_addrlen);
      if (socket < 0) continue;
      sockets_.push_back(socket);
      address_.port = static_cast<std::uint16_t>(port_of(socket));
    }
  };
  errno = EADDRNOTAVAIL;
  listen_on_all();
  if (sockets_.empty() && address_.host == "0.0.0.0") {
    addresses = resolve(address_.host, address_.port);
    listen_on_all();
  }
  if (!sockets_.empty()) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat(
      "cannot listen on ", name, ": in use, or not an address of this machine (", std::strerror(errno), ")"));
}

void Listener::start(Acceptor acceptor) {
  acceptor_ = std::move(acceptor);
  thread_ = std::thread([this] { run(); });
}

void Listener::stop() {
  stopping_ = true;
  const std::uint64_t one = 1;
  static_cast<void>(!::write(wake_, &one, sizeof(one)));
  if (thread_.joinable()) thread_.join();
  close_sockets();
}

void Listener::close_sockets() {
  for (const int socket : sockets_) ::close(socket);
  sockets_.clear();
}

void Listener::run() {
  Clock::time_point next_sweep = Clock::now() + kSweepInterval;
  std::uint64_t sweeps = 0;
  while (!stopping_) {
    std::vector<pollfd> waiting{{.fd = wake_, .events = POLLIN, .revents = 0}};
    for (const int socket : sockets_) waiting.push_back({.fd = socket, .events = POLLIN, .revents = 0});
    ::poll(waiting.data(), waiting.size(), static_cast<int>((broken_ ? kPause : kSweepInterval).count()));
    for (std::size_t i = 1; i < waiting.size(); ++i) {
      if ((waiting[i].revents & (POLLERR | POLLHUP | POLLNVAL)) != 0) broken_ = true;
      if ((waiting[i].revents & POLLIN) != 0) accept_waiting(waiting[i].fd);
    }
    if (broken_ && !stopping_) {
      close_sockets();
      const absl::Status status = listen();
      broken_ = !status.ok();
      spdlog::error("the listening socket of {} failed; {}", address_.to_string(),
                    status.ok() ? "it is opened anew" : std::string(status.message()));
    }
    if (const Clock::time_point now = Clock::now(); now >= next_sweep) {
      connections_.sweep(now);
      next_sweep = now + kSweepInterval;
      if (++sweeps % kSweepsPerTrim == 0) trim_free_memory();
    }
  }
}

void Listener::accept_waiting(int socket) {
  for (int i = 0; i < kMostAtOnce; ++i) {
    const int connection = ::accept4(socket, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (connection >= 0) {
      hand_over(connection, socket);
    } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
      return;
    } else if (!bear(errno, socket)) {
      broken_ = true;
      return;
    }
  }
}

bool Listener::bear(int error, int socket) {
  switch (error) {
    case EBADF:
    case EINVAL:
    case ENOTSOCK:
    case EOPNOTSUPP:
    case EFAULT:
      return false;
    case EMFILE:
    case ENFILE:
    case ENOBUFS:
    case ENOMEM: {
      const auto [write, left_out] = exhausted_.count();
      if (write) {
        spdlog::error("a connection cannot be accepted: {} ({} such lines left out before)",
                      std::strerror(error), left_out);
      }
      connections_.sweep(Clock::now());
      // Whoever waits is turned away instead of being left to wait for ever.
      if (spare_ >= 0) ::close(spare_);
      if (const int connection = ::accept4(socket, nullptr, nullptr, SOCK_CLOEXEC); connection >= 0)
        refuse(connection);
      spare_ = open_spare();
      return true;
    }
    default:
      return true;  // of the one connection that is not there any more, or of its network
  }
}

void Listener::hand_over(int connection, int socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  if (::getpeername(connection, reinterpret_cast<sockaddr*>(&address), &size) != 0) return refuse(connection);
  if (!connections_.admit(connection, Peer::of(address), kind_, Clock::now())) return refuse(connection);
  grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
  parameters.listener_fd = socket;
  parameters.fd = connection;
  acceptor_->HandleNewConnection(&parameters);
}

}  // namespace tessera::server
