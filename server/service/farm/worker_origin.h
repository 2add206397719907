// Where a worker's call comes from.
#pragma once

#include <memory>
#include <string>

#include "service/farm/accounts.h"

namespace tessera::server {

/// Who calls: the name in the caller's certificate, the fingerprint of its key (identity.h), and its
/// address. Empty where these are not known; whoever has no fingerprint is taken at their word.
struct WorkerOrigin {
  std::string certificate, peer, fingerprint;
  std::shared_ptr<const Accounts::Hold> account;  // holds what the worker takes, until it leaves
};

}  // namespace tessera::server
