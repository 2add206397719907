#include "connections/descriptors.h"

#include <sys/resource.h>

#include <algorithm>

namespace tessera::server {
namespace {

constexpr std::size_t kLeastKeptBack = 64, kMostKeptBack = 512;

}  // namespace

std::size_t raise_descriptor_limit() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return 0;
  const rlim_t wanted = std::min<rlim_t>(limit.rlim_max, kMostConnections + kMostKeptBack);
  if (limit.rlim_cur < wanted) {
    const rlimit raised{wanted, limit.rlim_max};
    if (::setrlimit(RLIMIT_NOFILE, &raised) == 0) limit = raised;
  }
  return static_cast<std::size_t>(limit.rlim_cur);
}

std::size_t connections_within(std::size_t descriptors) {
  const std::size_t kept = std::clamp(descriptors / 4, kLeastKeptBack, kMostKeptBack);
  return std::min(kMostConnections, descriptors - std::min(descriptors, kept));
}

}  // namespace tessera::server
