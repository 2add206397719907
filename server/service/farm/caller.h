// Who is at the other end of a call.
#pragma once

#include <optional>
#include <string>

#include "tls/role.h"

namespace tessera::server {

/// The other end of a call, by its certificate.
struct Caller {
  std::optional<Role> role;  // absent: the connection is not encrypted, and everything is allowed
  std::string user;          // the certificate's common name

  /// Whether this caller may see and change what belongs to `owner`.
  bool may_act_for(const std::string& owner) const { return !role || role == Role::kAdmin || user == owner; }
  /// Whether quotas hold for this caller: they do for neither administrators nor a farm without certificates.
  bool has_quotas() const { return role && role != Role::kAdmin; }
};

}  // namespace tessera::server
