#include "support/process/tcp_proxy.h"

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace tessera::support {
namespace {

constexpr int kLookAroundMs = 20;  // a change of the fault takes effect after this long

sockaddr_in loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  return address;
}

/// xorshift64 [Marsaglia 2003].
std::uint64_t next(std::uint64_t& state) {
  state ^= state << 13;
  state ^= state >> 7;
  return state ^= state << 17;
}

}  // namespace

TcpProxy::TcpProxy(int server_port)
    : server_port_(server_port), listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in address = loopback(0);
  socklen_t size = sizeof(address);
  if (listener_ < 0 || ::bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
      ::listen(listener_, 64) != 0 ||
      ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    const std::system_error error{errno, std::generic_category(), "listen"};
    if (listener_ >= 0) ::close(listener_);
    throw error;
  }
  port_ = ntohs(address.sin_port);
  accepting_ = std::jthread{[this](std::stop_token stop) { accept_all(stop); }};
}

TcpProxy::~TcpProxy() {
  accepting_.request_stop();
  accepting_.join();
  connections_.clear();
  ::close(listener_);
}

std::string TcpProxy::address() const { return "127.0.0.1:" + std::to_string(port_); }

void TcpProxy::accept_all(std::stop_token stop) {
  while (!stop.stop_requested()) {
    pollfd ready{listener_, POLLIN, 0};
    if (fault_ == Fault::kSilence || ::poll(&ready, 1, kLookAroundMs) <= 0) {
      if (fault_ == Fault::kSilence) std::this_thread::sleep_for(std::chrono::milliseconds{kLookAroundMs});
      continue;
    }
    const int client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (client < 0) continue;
    if (fault_ == Fault::kRefusing) {
      ::close(client);
      continue;
    }
    const std::uint64_t number = connections_.size();
    connections_.emplace_back([this, client, number](std::stop_token end) { forward(client, number, end); });
  }
}

void TcpProxy::forward(int client, std::uint64_t number, std::stop_token stop) {
  const int server = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_in address = loopback(server_port_);
  std::uint64_t random = 0x9e3779b97f4a7c15u * (number + 1);  // no two connections suffer alike
  std::uint64_t left_of_client = most_of_client_;
  bool open = ::connect(server, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  while (open && !stop.stop_requested() && fault_ != Fault::kRefusing) {
    const Fault fault = fault_;
    const short from_client =
        fault == Fault::kSilence || fault == Fault::kDeaf || left_of_client == 0 ? 0 : POLLIN;
    const short from_server = fault == Fault::kSilence || fault == Fault::kMute ? 0 : POLLIN;
    pollfd ends[2]{{from_client ? client : -1, from_client, 0}, {from_server ? server : -1, from_server, 0}};
    if (::poll(ends, 2, kLookAroundMs) <= 0) continue;
    if (ends[0].revents != 0) {
      const std::size_t bytes = pass(client, server, random);
      open = bytes > 0;
      left_of_client -= std::min<std::uint64_t>(left_of_client, bytes);
      forwarded_ += bytes;
    }
    if (open && ends[1].revents != 0) open = pass(server, client, random) > 0;
  }
  ::close(client);
  if (server >= 0) ::close(server);
}

std::size_t TcpProxy::pass(int from, int to, std::uint64_t& random) {
  unsigned char buffer[16384];
  ssize_t got = -1;
  do got = ::recv(from, buffer, sizeof(buffer), 0);
  while (got < 0 && errno == EINTR);
  if (got <= 0) return 0;
  if (const std::uint64_t every = flip_every_; every > 0) {
    for (ssize_t i = 0; i < got; ++i) {
      if (next(random) % every != 0) continue;
      buffer[i] ^= static_cast<unsigned char>(1u << (next(random) % 8));
      ++flipped_;
    }
  }
  for (ssize_t sent = 0; sent < got;) {
    const ssize_t more = ::send(to, buffer + sent, static_cast<std::size_t>(got - sent), MSG_NOSIGNAL);
    if (more <= 0) return 0;
    sent += more;
  }
  return static_cast<std::size_t>(got);
}

}  // namespace tessera::support
