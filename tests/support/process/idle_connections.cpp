#include "support/process/idle_connections.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace tessera::support {

IdleConnections::IdleConnections(const std::string& address)
    : host_(address.substr(0, address.rfind(':'))),
      port_(std::stoi(address.substr(address.rfind(':') + 1))) {}

void IdleConnections::open(std::size_t count) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port_));
  ::inet_pton(AF_INET, host_.c_str(), &to.sin_addr);
  for (std::size_t i = 0; i < count; ++i) {
    const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (socket < 0) throw std::system_error{errno, std::generic_category(), "no connection can be made"};
    const linger at_once{.l_onoff = 1, .l_linger = 0};
    ::setsockopt(socket, SOL_SOCKET, SO_LINGER, &at_once, sizeof(at_once));
    sockets_.push_back(socket);
    static_cast<void>(::connect(socket, reinterpret_cast<const sockaddr*>(&to), sizeof(to)));
  }
}

void IdleConnections::close_all() {
  for (const int socket : sockets_) ::close(socket);
  sockets_.clear();
}

}  // namespace tessera::support
