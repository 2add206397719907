// HOST:PORT as people type it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace tessera::base {

struct HostPort {
  std::string host;  // without brackets
  std::uint16_t port = 0;

  /// "host:port", with brackets around an IPv6 address.
  std::string to_string() const;
};

/// InvalidArgument, with what was expected, for anything but "host:port" and "[ipv6]:port".
absl::StatusOr<HostPort> parse_host_port(std::string_view text);

/// True for "localhost", 127.0.0.0/8 and ::1: bytes to such an address never leave the machine.
bool is_loopback(std::string_view host);

/// PermissionDenied for an address that is not loopback, unless `allow_insecure`: there is no encryption on
/// the way.
absl::Status check_unencrypted_allowed(const HostPort& address, bool allow_insecure);

}  // namespace tessera::base
