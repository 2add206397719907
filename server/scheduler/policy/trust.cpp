#include "scheduler/policy/trust.h"

#include "scheduler/identity.h"

namespace tessera::server {

std::optional<std::string> Trust::why_distrusted(const std::string& host) const {
  if (state_.distrusted.empty()) return std::nullopt;
  for (const std::string& subject : {host, identity_of(host)}) {
    if (const auto found = state_.distrusted.find(subject); found != state_.distrusted.end())
      return found->second;
  }
  return std::nullopt;
}

bool Trust::is_of_one_identity() const {
  std::size_t trusted = 0;
  for (const auto& [identity, workers] : state_.workers_by_identity) {
    if (!state_.distrusted.contains(identity) && ++trusted > 1) return false;
  }
  return true;
}

}  // namespace tessera::server
