#include "net/authorities.h"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509_vfy.h>

#include <memory>

#include "absl/strings/str_cat.h"
#include "base/freer.h"

namespace tessera::net {
namespace {

using PemReader = std::unique_ptr<BIO, base::Freer<BIO_free_all>>;
using Store = std::unique_ptr<X509_STORE, base::Freer<X509_STORE_free>>;
using Verification = std::unique_ptr<X509_STORE_CTX, base::Freer<X509_STORE_CTX_free>>;

}  // namespace

std::vector<Certificate> certificates_from_pem(std::string_view pem) {
  // Without a function for the password, OpenSSL would ask for it on the terminal.
  const auto no_password = [](char*, int, int, void*) { return -1; };
  std::vector<Certificate> certificates;
  const PemReader reader{BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size()))};
  while (reader != nullptr) {
    Certificate next{PEM_read_bio_X509(reader.get(), nullptr, no_password, nullptr)};
    if (next == nullptr) break;
    certificates.push_back(std::move(next));
  }
  ERR_clear_error();
  return certificates;
}

absl::Status check_signed(std::string_view authorities_pem, X509* certificate, const std::string& what) {
  const Store store{X509_STORE_new()};
  const Verification verification{X509_STORE_CTX_new()};
  for (const Certificate& authority : certificates_from_pem(authorities_pem))
    X509_STORE_add_cert(store.get(), authority.get());
  X509_STORE_CTX_init(verification.get(), store.get(), certificate, nullptr);
  if (X509_verify_cert(verification.get()) == 1) return absl::OkStatus();
  const int error = X509_STORE_CTX_get_error(verification.get());
  const std::string message = absl::StrCat(what, ": ", X509_verify_cert_error_string(error));
  const bool untimely = error == X509_V_ERR_CERT_HAS_EXPIRED || error == X509_V_ERR_CERT_NOT_YET_VALID;
  return untimely ? absl::FailedPreconditionError(message) : absl::InvalidArgumentError(message);
}

}  // namespace tessera::net
