// A request as a browser sends it.
#pragma once

#include <string>

namespace tessera::support {

/// Returns what a server on 127.0.0.1 answers to GET; what has come of it when the server closes the
/// connection or says nothing for 20 s, and nothing when there is no server.
std::string http_get(int port, const std::string& path);

}  // namespace tessera::support
