// Whether a browser's request is one that the page itself makes.
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "service/web/http.h"

namespace tessera::server {

/// PermissionDenied for requests that another site's page could make a browser send: for a host that is
/// neither an address, nor "localhost", nor in `names` (a site that lets its name point here: DNS rebinding);
/// from another origin; and for changes that are not JSON with the header X-Tessera, which pages of others
/// cannot send unasked.
absl::Status check_same_site(const HttpRequest& request, const std::vector<std::string>& names);

/// "host" of "host:port" and "[host]:port", in lower case; empty for anything else.
std::string host_of(const std::string& host_header);

}  // namespace tessera::server
