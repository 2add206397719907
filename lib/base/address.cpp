#include "base/address.h"

#include <arpa/inet.h>

#include <charconv>

#include "absl/strings/str_cat.h"

namespace tessera::base {

std::string HostPort::to_string() const {
  const bool ipv6 = host.find(':') != std::string::npos;
  return ipv6 ? absl::StrCat("[", host, "]:", port) : absl::StrCat(host, ":", port);
}

absl::StatusOr<HostPort> parse_host_port(std::string_view text) {
  const auto unsound = [&](const char* what) {
    return absl::InvalidArgumentError(absl::StrCat("\"", std::string(text), "\" is not an address: ", what,
                                                   "; expected HOST:PORT, such as 127.0.0.1:7070"));
  };
  HostPort address;
  std::string_view port;
  if (text.starts_with('[')) {
    const std::size_t close = text.find("]:");
    if (close == std::string_view::npos) return unsound("no \"]:\" after the IPv6 address");
    address.host = text.substr(1, close - 1);
    port = text.substr(close + 2);
  } else {
    const std::size_t colon = text.rfind(':');
    if (colon == std::string_view::npos) return unsound("no port");
    address.host = text.substr(0, colon);
    port = text.substr(colon + 1);
    if (address.host.find(':') != std::string::npos)
      return unsound("an IPv6 address needs brackets, as in [::1]:7070");
  }
  if (address.host.empty()) return unsound("no host");
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), address.port);
  if (port.empty() || error != std::errc() || end != port.data() + port.size()) {
    return unsound("the port is not a number from 0 to 65535");
  }
  return address;
}

bool is_loopback(std::string_view host) {
  if (host == "localhost") return true;
  const std::string text(host);
  in_addr v4{};
  if (inet_pton(AF_INET, text.c_str(), &v4) == 1) return (ntohl(v4.s_addr) >> 24) == 127;
  in6_addr v6{};
  return inet_pton(AF_INET6, text.c_str(), &v6) == 1 && IN6_IS_ADDR_LOOPBACK(&v6);
}

absl::Status check_unencrypted_allowed(const HostPort& address, bool allow_insecure) {
  if (allow_insecure || is_loopback(address.host)) return absl::OkStatus();
  return absl::PermissionDeniedError(
      absl::StrCat(address.to_string(),
                   " is not a loopback address and the connection is not encrypted; "
                   "name certificates with --tls (tessera-server --init-tls makes "
                   "them), or pass --allow-insecure on a network that you trust"));
}

}  // namespace tessera::base
