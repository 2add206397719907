// Whom the holder of a folder of certificates (tls.h) trusts: one authority, or several, while a farm changes
// from one to another.
#pragma once

#include <openssl/x509.h>

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "net/x509.h"

namespace tessera::net {

/// Reads all certificates in `pem`.
std::vector<Certificate> certificates_from_pem(std::string_view pem);

/// Why none of these authorities stands for `certificate`, which is called `what` in messages:
/// InvalidArgument (none of them has signed it), FailedPrecondition (expired, or not valid yet).
absl::Status check_signed(std::string_view authorities_pem, X509* certificate, const std::string& what);

}  // namespace tessera::net
