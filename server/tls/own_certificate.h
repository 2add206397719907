// Checks of a coordinator's own certificate before it serves with it.
#pragma once

#include <filesystem>

#include "absl/status/status.h"

namespace tessera::server {

/// InvalidArgument, saying what to do, when the key in `folder` (net/tls.h) can be read by every user
/// of the machine. OK where there is no key.
absl::Status check_private_key(const std::filesystem::path& folder);

/// The same for the coordinator's own folder; also when its certificate is one of a worker, a client or an
/// administrator: what holds such a key would pass for the coordinator with nobody, and its copies are where
/// clients are.
absl::Status check_own_certificate(const std::filesystem::path& folder);

}  // namespace tessera::server
