// How a new machine becomes a worker of a farm: with a join token instead of a copied key.
#pragma once

#include <filesystem>
#include <string>

#include "absl/status/status.h"

namespace tessera::agent {

struct JoinRequest {
  std::string server;        // HOST:PORT of the coordinator
  std::string token;         // text of a net/join_token.h
  std::string machine_name;  // common name in its certificate
  std::filesystem::path certificate_folder;
};

/// Makes a key, has the farm's authority certify it, and leaves both in the folder, as net/tls.h wants
/// them. The key does not leave this machine, and the secret of the token is said only to a server that the
/// token's authority vouches for. A folder with sound certificates is left as it is, so that a worker may be
/// started with the same token again. InvalidArgument (token, address or name), PermissionDenied (the
/// server's authority is not the token's, or the token is not valid), Unavailable (server, or files).
absl::Status join_farm(const JoinRequest& request);

}  // namespace tessera::agent
