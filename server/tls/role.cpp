#include "tls/role.h"

#include <array>

namespace tessera::server {
namespace {

constexpr std::string_view kPrefix = "tessera:";
constexpr std::array kRoles{Role::kServer, Role::kWorker, Role::kClient, Role::kAdmin};

}  // namespace

const char* to_string(Role role) {
  constexpr std::array kNames{"server", "worker", "client", "admin"};
  return kNames[static_cast<std::size_t>(role)];
}

std::optional<Role> role_of_name(std::string_view name) {
  for (const Role role : kRoles) {
    if (name == to_string(role)) return role;
  }
  return std::nullopt;
}

std::string role_uri(Role role) { return std::string{kPrefix} + to_string(role); }

std::optional<Role> role_of_uri(std::string_view uri) {
  for (const Role role : kRoles) {
    if (uri == role_uri(role)) return role;
  }
  return std::nullopt;
}

}  // namespace tessera::server
