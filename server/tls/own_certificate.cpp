#include "tls/own_certificate.h"

#include <fstream>
#include <iterator>
#include <optional>
#include <string>

#include "absl/strings/str_cat.h"
#include "net/tls.h"
#include "net/x509.h"
#include "tls/role.h"

namespace tessera::server {

absl::Status check_private_key(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  const fs::path key = folder / net::kKeyFile;
  std::error_code error;
  const fs::perms others = fs::status(key, error).permissions() & fs::perms::others_all;
  if (error || others == fs::perms::none) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(key.string(),
                   " can be read by everybody on this machine: chmod 600 it, or, if others may have read "
                   "it, make new certificates with --init-tls"));
}

absl::Status check_own_certificate(const std::filesystem::path& folder) {
  if (absl::Status status = check_private_key(folder); !status.ok()) return status;
  const std::filesystem::path path = folder / net::kCertificateFile;
  std::ifstream in{path};
  const std::string pem{std::istreambuf_iterator<char>(in), {}};
  const net::Certificate certificate = net::certificate_from_pem(pem);
  if (certificate == nullptr)
    return absl::InvalidArgumentError(absl::StrCat(path.string(), " cannot be read"));
  for (const std::string& uri : net::uris_of(certificate.get())) {
    const std::optional<Role> role = role_of_uri(uri);
    if (!role || role == Role::kServer) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        path.string(), " is the certificate of a ", to_string(*role), " ('", net::name_of(certificate.get()),
        "'): --tls of tessera-server wants the folder \"server\" that "
        "--init-tls made"));
  }
  return absl::OkStatus();
}

}  // namespace tessera::server
