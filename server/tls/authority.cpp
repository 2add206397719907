#include "tls/authority.h"

#include <fcntl.h>
#include <openssl/bn.h>
#include <openssl/ec.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "wire/freer.h"
#include "wire/tls.h"

namespace tessera::server {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::system_clock;

constexpr std::chrono::hours kDay{24};
constexpr auto kAuthorityLife = 3650 * kDay;
constexpr auto kCertificateLife = 397 * kDay;  // what browsers accept at most: a habit worth having
constexpr auto kClockSlack = std::chrono::hours{1};

using Certificate = std::unique_ptr<X509, wire::Freer<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, wire::Freer<EVP_PKEY_free>>;
using File = std::unique_ptr<std::FILE, wire::Freer<std::fclose>>;

absl::Status openssl_error(const std::string& what) {
  std::array<char, 256> reason{};
  ERR_error_string_n(ERR_get_error(), reason.data(), reason.size());
  ERR_clear_error();
  return absl::InternalError(absl::StrCat(what, ": ", reason.data()));
}

absl::Status file_error(const fs::path& path) {
  return absl::UnavailableError(absl::StrCat(path.string(), ": ", std::strerror(errno)));
}

/// Through a file beside it, so that whoever reads sees the old or the new one.
template <class Write>
absl::Status replace_file(const fs::path& path, mode_t mode, Write write) {
  const fs::path draft = path.string() + ".new";
  ::unlink(draft.c_str());
  const int descriptor = ::open(draft.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  if (descriptor < 0) return file_error(draft);
  File file{::fdopen(descriptor, "wb")};
  const bool written = write(file.get()) == 1 && std::fflush(file.get()) == 0 && ::fsync(descriptor) == 0;
  file.reset();
  if (!written || std::rename(draft.c_str(), path.c_str()) != 0) return file_error(path);
  return absl::OkStatus();
}

absl::Status make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return absl::UnavailableError(absl::StrCat(folder.string(), ": ", error.message()));
  return absl::OkStatus();
}

absl::Status write_key(EVP_PKEY* key, const fs::path& folder) {
  return replace_file(folder / wire::kKeyFile, 0600, [&](std::FILE* file) {
    return PEM_write_PrivateKey(file, key, nullptr, nullptr, 0, nullptr, nullptr);
  });
}

absl::Status write_certificate(X509* certificate, const fs::path& path) {
  return replace_file(path, 0644, [&](std::FILE* file) { return PEM_write_X509(file, certificate); });
}

bool add_extension(X509* certificate, X509* issuer, int kind, const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  const std::unique_ptr<X509_EXTENSION, wire::Freer<X509_EXTENSION_free>> extension{
      X509V3_EXT_conf_nid(nullptr, &context, kind, value.c_str())};
  return extension != nullptr && X509_add_ext(certificate, extension.get(), -1) == 1;
}

bool set_random_serial(X509* certificate) {
  const std::unique_ptr<BIGNUM, wire::Freer<BN_free>> number{BN_new()};
  return BN_rand(number.get(), 127, BN_RAND_TOP_ANY, BN_RAND_BOTTOM_ANY) == 1 &&
         BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(certificate)) != nullptr;
}

/// A certificate for the holder of `key`, not signed yet, without its extensions.
Certificate draft_certificate(EVP_PKEY* key, const std::string& name, Clock::time_point begin, Clock::time_point end) {
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
    const std::unique_ptr<ASN1_OCTET_STRING, wire::Freer<ASN1_OCTET_STRING_free>> numeric{a2i_IPADDRESS(host.c_str())};
    names.push_back((numeric != nullptr ? "IP:" : "DNS:") + host);
    ERR_clear_error();
  }
  return absl::StrJoin(names, ",");
}

/// Names go into a list that commas separate, and into folder names.
absl::Status check_name(const std::string& what, const std::string& name) {
  const bool sound = !name.empty() && name.size() <= 64 && name.front() != '.' &&
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
};

Authority::Authority(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Authority::Authority(Authority&&) noexcept = default;
Authority& Authority::operator=(Authority&&) noexcept = default;
Authority::~Authority() = default;

absl::StatusOr<Authority> Authority::open(const fs::path& folder) {
  if (auto s = make_folder(folder); !s.ok()) return s;
  const fs::path certificate_path = folder / wire::kTrustedFile;
  auto parts = std::make_unique<Parts>();
  if (const File file{std::fopen(certificate_path.c_str(), "rb")}; file != nullptr) {
    parts->certificate.reset(PEM_read_X509(file.get(), nullptr, nullptr, nullptr));
    const File key_file{std::fopen((folder / wire::kKeyFile).c_str(), "rb")};
    if (key_file == nullptr) return file_error(folder / wire::kKeyFile);
    parts->key.reset(PEM_read_PrivateKey(key_file.get(), nullptr, nullptr, nullptr));
    ERR_clear_error();
    if (parts->certificate == nullptr || parts->key == nullptr ||
        X509_check_private_key(parts->certificate.get(), parts->key.get()) != 1) {
      ERR_clear_error();
      return absl::InvalidArgumentError(absl::StrCat(folder.string(), " does not hold an authority and its key"));
    }
    return Authority{std::move(parts)};
  }
  parts->key.reset(EVP_EC_gen("P-256"));
  if (parts->key == nullptr) return openssl_error("making a key");
  const auto now = Clock::now();
  parts->certificate =
      draft_certificate(parts->key.get(), "Tessera farm authority", now - kClockSlack, now + kAuthorityLife);
  X509* const c = parts->certificate.get();
  if (c == nullptr || X509_set_issuer_name(c, X509_get_subject_name(c)) != 1 ||
      !add_extension(c, c, NID_basic_constraints, "critical,CA:TRUE,pathlen:0") ||
      !add_extension(c, c, NID_key_usage, "critical,keyCertSign,cRLSign") ||
      !add_extension(c, c, NID_subject_key_identifier, "hash") || X509_sign(c, parts->key.get(), EVP_sha256()) == 0) {
    return openssl_error("making the authority");
  }
  // The certificate last: without it, there is no authority yet.
  if (auto s = write_key(parts->key.get(), folder); !s.ok()) return s;
  if (auto s = write_certificate(c, certificate_path); !s.ok()) return s;
  return Authority{std::move(parts)};
}

absl::Status Authority::issue(const Identity& identity, const fs::path& folder, Clock::time_point begin,
                              Clock::time_point end) const {
  if (auto s = check_name("name", identity.name); !s.ok()) return s;
  for (const std::string& host : identity.hosts) {
    if (auto s = check_name("host", host); !s.ok()) return s;
  }
  if (auto s = make_folder(folder); !s.ok()) return s;
  const Key key{EVP_EC_gen("P-256")};
  if (key == nullptr) return openssl_error("making a key");
  const Certificate certificate = draft_certificate(key.get(), identity.name, begin, end);
  X509* const c = certificate.get();
  X509* const issuer = parts_->certificate.get();
  const char* const usage = identity.role == Role::kServer ? "serverAuth" : "clientAuth";
  if (c == nullptr || X509_set_issuer_name(c, X509_get_subject_name(issuer)) != 1 ||
      !add_extension(c, issuer, NID_basic_constraints, "critical,CA:FALSE") ||
      !add_extension(c, issuer, NID_key_usage, "critical,digitalSignature") ||
      !add_extension(c, issuer, NID_ext_key_usage, usage) ||
      !add_extension(c, issuer, NID_subject_alt_name, alternative_names(identity)) ||
      !add_extension(c, issuer, NID_authority_key_identifier, "keyid") ||
      X509_sign(c, parts_->key.get(), EVP_sha256()) == 0) {
    return openssl_error(absl::StrCat("making the certificate of ", identity.name));
  }
  if (auto s = write_key(key.get(), folder); !s.ok()) return s;
  if (auto s = write_certificate(c, folder / wire::kCertificateFile); !s.ok()) return s;
  return write_certificate(issuer, folder / wire::kTrustedFile);
}

absl::Status write_farm_certificates(const fs::path& folder, const std::vector<std::string>& hosts,
                                     const std::vector<std::string>& users) {
  const absl::StatusOr<Authority> authority = Authority::open(folder / "authority");
  if (!authority.ok()) return authority.status();
  Identity server{.role = Role::kServer, .name = "tessera-server", .hosts = {"localhost", "127.0.0.1", "::1"}};
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
    if (auto s = authority->issue(identity, folder / name, now - kClockSlack, now + kCertificateLife); !s.ok())
      return s;
  }
  return absl::OkStatus();
}

}  // namespace tessera::server
