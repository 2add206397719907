#include "service/web/own_certificates.h"

#include <gnutls/abstract.h>
#include <gnutls/gnutls.h>

#include <array>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "net/tls.h"

namespace tessera::server {
namespace {

std::string file_contents(const std::filesystem::path& path) {
  std::ifstream in{path, std::ios::binary};
  return {std::istreambuf_iterator<char>(in), {}};
}

gnutls_datum_t datum_of(std::string& text) {
  return {.data = reinterpret_cast<unsigned char*>(text.data()), .size = static_cast<unsigned>(text.size())};
}

}  // namespace

struct OwnCertificates::Pair {
  static constexpr unsigned kLongestChain = 4;

  Pair() = default;
  Pair(const Pair&) = delete;
  Pair& operator=(const Pair&) = delete;
  ~Pair() {
    for (unsigned i = 0; i < length; ++i) gnutls_pcert_deinit(&chain[i]);
    if (key != nullptr) gnutls_privkey_deinit(key);
  }

  /// A code of GnuTLS.
  int read(std::string certificate_pem, std::string key_pem) {
    const gnutls_datum_t certificate = datum_of(certificate_pem), secret = datum_of(key_pem);
    unsigned count = kLongestChain;
    int code = gnutls_pcert_list_import_x509_raw(chain.data(), &count, &certificate, GNUTLS_X509_FMT_PEM, 0);
    if (code < 0) return code;
    length = count;
    if (code = gnutls_privkey_init(&key); code < 0) return code;
    return gnutls_privkey_import_x509_raw(key, &secret, GNUTLS_X509_FMT_PEM, nullptr, 0);
  }

  std::array<gnutls_pcert_st, kLongestChain> chain{};
  unsigned length = 0;
  gnutls_privkey_t key = nullptr;
};

OwnCertificates::OwnCertificates() = default;
OwnCertificates::~OwnCertificates() = default;

OwnCertificates::Written OwnCertificates::written(const std::filesystem::path& folder) {
  std::error_code error;
  return {.key = std::filesystem::last_write_time(folder / net::kKeyFile, error),
          .certificate = std::filesystem::last_write_time(folder / net::kCertificateFile, error),
          .trusted = std::filesystem::last_write_time(folder / net::kTrustedFile, error)};
}

bool OwnCertificates::has_news(const std::filesystem::path& folder) {
  const std::lock_guard lock(mutex_);
  return written(folder) != seen_;
}

absl::Status OwnCertificates::read(const std::filesystem::path& folder) {
  // Before they are read: what is written meanwhile is news.
  const Written seen = written(folder);
  auto pair = std::make_unique<Pair>();
  std::string trusted = file_contents(folder / net::kTrustedFile);
  absl::Status status = net::check_certificates(folder.string());
  if (status.ok()) {
    const int code =
        pair->read(file_contents(folder / net::kCertificateFile), file_contents(folder / net::kKeyFile));
    if (code < 0) {
      status = absl::InvalidArgumentError(
          absl::StrCat(folder.string(), ": GnuTLS cannot use its certificate: ", gnutls_strerror(code)));
    }
  }
  const std::lock_guard lock(mutex_);
  seen_ = seen;
  if (!status.ok()) return status;
  pairs_.push_back(std::move(pair));
  trusted_ = std::move(trusted);
  return absl::OkStatus();
}

std::string OwnCertificates::trusted() const {
  const std::lock_guard lock(mutex_);
  return trusted_;
}

OwnCertificates::Shown OwnCertificates::shown() const {
  const std::lock_guard lock(mutex_);
  if (pairs_.empty()) return {};
  Pair& last = *pairs_.back();
  return {.chain = last.chain.data(), .length = last.length, .key = last.key};
}

}  // namespace tessera::server
