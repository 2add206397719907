// How many descriptors the coordinator may have open, and how many of them connections may take.
#pragma once

#include <cstddef>

namespace tessera::server {

/// Raises the process's own limit towards the system's, up to what kMostConnections need. Returns the limit.
std::size_t raise_descriptor_limit();

/// More connections than this are not taken, whatever the limit: each takes some tens of kilobytes.
inline constexpr std::size_t kMostConnections = std::size_t{1} << 16;

/// Connections that a limit of descriptors leaves room for: journal, results and blobs keep a quarter, 64 to
/// 512.
std::size_t connections_within(std::size_t descriptors);

}  // namespace tessera::server
