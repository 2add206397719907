// Which addresses the coordinator calls.
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"

namespace tessera::server {

/// Whether the text is an http or https URL that the coordinator may be told to call: with a host, without a
/// user, a password or a fragment, and without characters in its path that servers read in different ways
/// ("\", and what is encoded of "." and of separators). InvalidArgument, with what is wrong.
absl::Status check_url(const std::string& url);

/// Whether one of the `allowed` URLs covers this one: same scheme, host and port, and a path that is the
/// allowed one, or lies below it where that ends with "/". A user names URLs that the coordinator calls from
/// within its network, so that this list decides where to. PermissionDenied where none does, or the URL is
/// not sound.
absl::Status check_allowed(const std::string& url, const std::vector<std::string>& allowed);

}  // namespace tessera::server
