// Whom the farm believes.
#pragma once

#include <optional>
#include <string>

#include "scheduler/farm_state.h"

namespace tessera::server {

/// Hosts and identities (identity.h) in quarantine. Who gets there, and out again, is decided by Audits.
class Trust {
 public:
  explicit Trust(const FarmState& state) : state_(state) {}

  /// Why the host, or its identity, is in quarantine; none where neither is.
  std::optional<std::string> why_distrusted(const std::string& host) const;
  bool trusts(const std::string& host) const { return !why_distrusted(host); }
  /// Whether all workers that are trusted are of one identity, so that only its hosts can be told apart.
  bool is_of_one_identity() const;

 private:
  const FarmState& state_;
};

}  // namespace tessera::server
