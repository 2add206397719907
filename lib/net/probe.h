// Probe of what listens at an address.
#pragma once

#include <chrono>

#include "base/address.h"

namespace tessera::net {

enum class Speaks {
  kNobody,  // nobody listens, the host has no such name, or it cannot be reached
  kPlain,   // gRPC without encryption
  kTls,
  kUnclear,  // something listens, and said neither in time
};

/// Connects, begins a TLS handshake, and looks at the first byte that comes back. For messages to people,
/// after a call has failed.
Speaks probe(const base::HostPort& address, std::chrono::milliseconds patience);

}  // namespace tessera::net
