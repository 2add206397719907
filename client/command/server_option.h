// --server, and the connection that it names.
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "command/command_line.h"
#include "farm/farm_client.h"

namespace tessera::client {

struct ServerOption {
  std::string address = "127.0.0.1:7070";
  std::string certificates;  // a folder; empty: no encryption
  bool allow_insecure = false;
};

/// Defines --server (else $TESSERA_SERVER, else 127.0.0.1:7070) --tls (else $TESSERA_TLS) and
/// --allow-insecure.
void define_server_option(options::Command& command, ServerOption& option);

/// A client that tells about breaks of the connection on stderr, unless `quiet`. InvalidArgument for a
/// malformed address, PermissionDenied for one that would need encryption.
absl::StatusOr<std::unique_ptr<FarmClient>> connect(const ServerOption& option, bool quiet = false);

/// Prints the error of a call to the coordinator, and returns the exit code. Of one that cannot be reached,
/// it says what is there instead, and what to do.
int report_farm_error(const absl::Status& status, const ServerOption& option);

}  // namespace tessera::client
