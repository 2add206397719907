#include "tls/authority.h"

#include <openssl/bn.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/x509v3.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "base/freer.h"
#include "base/private_file.h"
#include "net/authorities.h"
#include "net/tls.h"
#include "net/x509.h"

namespace tessera::server {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::system_clock;

constexpr std::chrono::hours kDay{24};
constexpr auto kAuthorityLife = 3650 * kDay;

using net::Certificate;
using net::Key;

absl::Status openssl_error(const std::string& what) {
  std::array<char, 256> reason{};
  ERR_error_string_n(ERR_get_error(), reason.data(), reason.size());
  ERR_clear_error();
  return absl::InternalError(absl::StrCat(what, ": ", reason.data()));
}

absl::Status write_key(EVP_PKEY* key, const fs::path& folder) {
  return base::replace_file(folder / net::kKeyFile, 0600, net::to_pem(key));
}

absl::Status write_certificate(X509* certificate, const fs::path& path) {
  return base::replace_file(path, 0644, net::to_pem(certificate));
}

absl::StatusOr<std::string> read_file(const fs::path& path) {
  std::ifstream in{path, std::ios::binary};
  std::string bytes{std::istreambuf_iterator<char>{in}, {}};
  if (!in) return absl::UnavailableError(absl::StrCat(path.string(), " cannot be read"));
  return bytes;
}

bool add_extension(X509* certificate, X509* issuer, int kind, const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  const std::unique_ptr<X509_EXTENSION, base::Freer<X509_EXTENSION_free>> extension{
      X509V3_EXT_conf_nid(nullptr, &context, kind, value.c_str())};
  return extension != nullptr && X509_add_ext(certificate, extension.get(), -1) == 1;
}

bool set_random_serial(X509* certificate) {
  const std::unique_ptr<BIGNUM, base::Freer<BN_free>> number{BN_new()};
  return BN_rand(number.get(), 127, BN_RAND_TOP_ANY, BN_RAND_BOTTOM_ANY) == 1 &&
         BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(certificate)) != nullptr;
}

/// A certificate for the holder of `key`, not signed yet, without its extensions.
Certificate draft_certificate(EVP_PKEY* key, const std::string& name, Clock::time_point begin,
                              Clock::time_point end) {
  Certificate certificate{X509_new()};
  X509* const c = certificate.get();
  X509_NAME* const subject = X509_get_subject_name(c);
  const auto* const text = reinterpret_cast<const unsigned char*>(name.data());
  const bool made = X509_set_version(c, 2) == 1 && set_random_serial(c) &&
                    ASN1_TIME_set(X509_getm_notBefore(c), Clock::to_time_t(begin)) != nullptr &&
                    ASN1_TIME_set(X509_getm_notAfter(c), Clock::to_time_t(end)) != nullptr &&
                    X509_NAME_add_entry_by_NID(subject, NID_commonName, MBSTRING_UTF8, text,
                                               static_cast<int>(name.size()), -1, 0) == 1 &&
                    X509_set_pubkey(c, key) == 1;
  return made ? std::move(certificate) : nullptr;
}

/// The subject alternative names of an identity, as OpenSSL writes them.
std::string alternative_names(const Identity& identity) {
  std::vector<std::string> names{"URI:" + role_uri(identity.role)};
  for (const std::string& host : identity.hosts) {
    const std::unique_ptr<ASN1_OCTET_STRING, base::Freer<ASN1_OCTET_STRING_free>> numeric{
        a2i_IPADDRESS(host.c_str())};
    names.push_back((numeric != nullptr ? "IP:" : "DNS:") + host);
    ERR_clear_error();
  }
  return absl::StrJoin(names, ",");
}

/// Names go into a list that commas separate, and into folder names.
absl::Status check_name(const std::string& what, const std::string& name) {
  const bool sound =
      !name.empty() && name.size() <= 64 && name.front() != '.' &&
      name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-:@*") ==
          std::string::npos;
  if (sound) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(what, " '", name, "': 1 to 64 letters, digits and . _ - : @ were expected"));
}

}  // namespace

struct Authority::Parts {
  Key key;
  Certificate certificate;

  /// A certificate of `identity` for the holder of a key.
  absl::StatusOr<Certificate> sign(EVP_PKEY* holder, const Identity& identity, Clock::time_point begin,
                                   Clock::time_point end) const;
};

absl::StatusOr<Certificate> Authority::Parts::sign(EVP_PKEY* holder, const Identity& identity,
                                                   Clock::time_point begin, Clock::time_point end) const {
  if (auto s = check_name("name", identity.name); !s.ok()) return s;
  for (const std::string& host : identity.hosts) {
    if (auto s = check_name("host", host); !s.ok()) return s;
  }
  Certificate made = draft_certificate(holder, identity.name, begin, end);
  X509* const c = made.get();
  X509* const issuer = certificate.get();
  const char* const usage = identity.role == Role::kServer ? "serverAuth" : "clientAuth";
  if (c == nullptr || X509_set_issuer_name(c, X509_get_subject_name(issuer)) != 1 ||
      !add_extension(c, issuer, NID_basic_constraints, "critical,CA:FALSE") ||
      !add_extension(c, issuer, NID_key_usage, "critical,digitalSignature") ||
      !add_extension(c, issuer, NID_ext_key_usage, usage) ||
      !add_extension(c, issuer, NID_subject_alt_name, alternative_names(identity)) ||
      !add_extension(c, issuer, NID_authority_key_identifier, "keyid") ||
      X509_sign(c, key.get(), EVP_sha256()) == 0) {
    return openssl_error(absl::StrCat("making the certificate of ", identity.name));
  }
  return made;
}

Authority::Authority(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Authority::Authority(Authority&&) noexcept = default;
Authority& Authority::operator=(Authority&&) noexcept = default;
Authority::~Authority() = default;

absl::StatusOr<Authority> Authority::open_existing(const fs::path& folder) {
  const absl::StatusOr<std::string> certificate = read_file(folder / net::kTrustedFile);
  if (!certificate.ok()) return certificate.status();
  const absl::StatusOr<std::string> key = read_file(folder / net::kKeyFile);
  if (!key.ok()) return key.status();
  auto parts = std::make_unique<Parts>();
  parts->certificate = net::certificate_from_pem(*certificate);
  parts->key = net::key_from_pem(*key);
  if (parts->certificate == nullptr || parts->key == nullptr ||
      X509_check_private_key(parts->certificate.get(), parts->key.get()) != 1) {
    ERR_clear_error();
    return absl::InvalidArgumentError(
        absl::StrCat(folder.string(), " does not hold an authority and its key"));
  }
  return Authority{std::move(parts)};
}

absl::StatusOr<Authority> Authority::open(const fs::path& folder) {
  if (auto s = base::make_folder(folder); !s.ok()) return s;
  if (fs::exists(folder / net::kTrustedFile)) return open_existing(folder);
  auto parts = std::make_unique<Parts>();
  parts->key = net::make_key();
  if (parts->key == nullptr) return openssl_error("making a key");
  const auto now = Clock::now();
  parts->certificate =
      draft_certificate(parts->key.get(), "Tessera farm authority", now - kClockSlack, now + kAuthorityLife);
  X509* const c = parts->certificate.get();
  if (c == nullptr || X509_set_issuer_name(c, X509_get_subject_name(c)) != 1 ||
      !add_extension(c, c, NID_basic_constraints, "critical,CA:TRUE,pathlen:0") ||
      !add_extension(c, c, NID_key_usage, "critical,keyCertSign,cRLSign") ||
      !add_extension(c, c, NID_subject_key_identifier, "hash") ||
      X509_sign(c, parts->key.get(), EVP_sha256()) == 0) {
    return openssl_error("making the authority");
  }
  // The certificate last: without it, there is no authority yet.
  if (auto s = write_key(parts->key.get(), folder); !s.ok()) return s;
  if (auto s = write_certificate(c, folder / net::kTrustedFile); !s.ok()) return s;
  return Authority{std::move(parts)};
}

std::string Authority::certificate_pem() const { return net::to_pem(parts_->certificate.get()); }

std::string Authority::digest() const { return net::digest_of(parts_->certificate.get()); }

bool Authority::is_trusted_by(const fs::path& folder) const {
  const absl::StatusOr<std::string> trusted = read_file(folder / net::kTrustedFile);
  if (!trusted.ok()) return false;
  const std::vector<Certificate> known = net::certificates_from_pem(*trusted);
  return std::any_of(known.begin(), known.end(), [&](const Certificate& certificate) {
    return X509_cmp(certificate.get(), parts_->certificate.get()) == 0;
  });
}

absl::Status Authority::issue(const Identity& identity, const fs::path& folder, Clock::time_point begin,
                              Clock::time_point end) const {
  const Key key = net::make_key();
  if (key == nullptr) return openssl_error("making a key");
  const absl::StatusOr<Certificate> certificate = parts_->sign(key.get(), identity, begin, end);
  if (!certificate.ok()) return certificate.status();
  if (auto s = base::make_folder(folder); !s.ok()) return s;
  if (auto s = write_key(key.get(), folder); !s.ok()) return s;
  if (auto s = write_certificate(certificate->get(), folder / net::kCertificateFile); !s.ok()) return s;
  return write_certificate(parts_->certificate.get(), folder / net::kTrustedFile);
}

absl::StatusOr<std::string> Authority::certify(const std::string& request_pem, const Identity& identity,
                                               Clock::time_point begin, Clock::time_point end) const {
  const net::CertificateRequest request = net::request_from_pem(request_pem);
  EVP_PKEY* const key = request == nullptr ? nullptr : X509_REQ_get0_pubkey(request.get());
  if (key == nullptr) return absl::InvalidArgumentError("this is no request for a certificate in PEM");
  if (!net::is_usual_key(key))
    return absl::InvalidArgumentError("the key of the request is not one on P-256");
  const bool proved = X509_REQ_verify(request.get(), key) == 1;
  ERR_clear_error();
  if (!proved) return absl::InvalidArgumentError("the request is not signed with its own key");
  const absl::StatusOr<Certificate> certificate = parts_->sign(key, identity, begin, end);
  if (!certificate.ok()) return certificate.status();
  return net::to_pem(certificate->get());
}

absl::Status write_farm_certificates(const fs::path& folder, const std::vector<std::string>& hosts,
                                     const std::vector<std::string>& users) {
  const absl::StatusOr<Authority> authority = Authority::open(folder / "authority");
  if (!authority.ok()) return authority.status();
  Identity server{
      .role = Role::kServer, .name = "tessera-server", .hosts = {"localhost", "127.0.0.1", "::1"}};
  std::array<char, 256> own{};
  if (::gethostname(own.data(), own.size() - 1) == 0 && check_name("host", own.data()).ok()) {
    server.hosts.emplace_back(own.data());
  }
  server.hosts.insert(server.hosts.end(), hosts.begin(), hosts.end());

  std::vector<std::pair<std::string, Identity>> wanted{
      {"server", server},
      {"worker", {.role = Role::kWorker, .name = "tessera-worker", .hosts = {}}},
      {"admin", {.role = Role::kAdmin, .name = "admin", .hosts = {}}}};
  for (const std::string& user : users) {
    wanted.emplace_back("client-" + user, Identity{.role = Role::kClient, .name = user, .hosts = {}});
  }
  const auto now = Clock::now();
  for (const auto& [name, identity] : wanted) {
    if (auto s = authority->issue(identity, folder / name, now - kClockSlack, now + kCertificateLife);
        !s.ok())
      return s;
  }
  return absl::OkStatus();
}

}  // namespace tessera::server
