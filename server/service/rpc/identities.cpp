#include "service/rpc/identities.h"

#include "net/x509.h"
#include "scheduler/identity.h"
#include "service/rpc/access.h"
#include "wire/digest.h"

namespace tessera::server {

std::string Identities::of(const grpc::AuthContext* context) {
  const std::string pem = context == nullptr ? "" : certificate_of(*context);
  if (pem.empty()) return "";
  {
    const std::lock_guard lock{mutex_};
    if (const auto found = by_pem_.find(pem); found != by_pem_.end()) return found->second;
  }
  const net::Certificate certificate = net::certificate_from_pem(pem);
  const std::string digest =
      certificate == nullptr ? wire::sha256_hex(pem) : net::key_digest_of(certificate.get());
  const std::lock_guard lock{mutex_};
  if (by_pem_.size() >= kMostKept) by_pem_.clear();
  return by_pem_[pem] = digest.substr(0, kFingerprintDigits);
}

}  // namespace tessera::server
