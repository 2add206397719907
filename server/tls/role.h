// Roles: what a certificate allows its holder to do on a farm.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace tessera::server {

enum class Role {
  kServer,  // is called
  kWorker,  // renders
  kClient,  // submits jobs and follows its own
  kAdmin,   // a client that may do all that clients do, with everybody's jobs
};

/// "worker" ...
const char* to_string(Role role);
std::optional<Role> role_of_name(std::string_view name);

/// The subject alternative name of a certificate that says the role: "tessera:worker" ...
std::string role_uri(Role role);
std::optional<Role> role_of_uri(std::string_view uri);

}  // namespace tessera::server
