#include "net/tls.h"

#include <grpcpp/security/credentials.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/security/tls_certificate_provider.h>
#include <grpcpp/security/tls_credentials_options.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "absl/strings/str_cat.h"
#include "base/freer.h"
#include "net/authorities.h"
#include "net/x509.h"

namespace tessera::net {
namespace {

std::string path_of(const std::string& folder, const char* file) { return absl::StrCat(folder, "/", file); }

/// Reads a file by `read`, which says whether that went well. NotFound when there is no such file.
template <class Read>
absl::Status read_pem(const std::string& path, Read read) {
  const std::unique_ptr<std::FILE, base::Freer<std::fclose>> file{std::fopen(path.c_str(), "rb")};
  if (file == nullptr) return absl::NotFoundError(absl::StrCat(path, " is missing or cannot be read"));
  if (read(file.get())) return absl::OkStatus();
  ERR_clear_error();
  return absl::InvalidArgumentError(absl::StrCat(path, " is not what it should be in PEM"));
}

absl::Status read_certificate(const std::string& path, Certificate& certificate) {
  return read_pem(path, [&](std::FILE* file) {
    certificate.reset(PEM_read_X509(file, nullptr, nullptr, nullptr));
    return certificate != nullptr;
  });
}

std::string text_of(const std::string& path) {
  std::ifstream in{path, std::ios::binary};
  return {std::istreambuf_iterator<char>(in), {}};
}

/// gRPC 1.51 cannot be told the least version of TLS, but the ciphers of TLS 1.2: one that needs a shared
/// key, which nobody has. It reads them once, before the first connection of the process.
void refuse_tls_1_2() {
  static const bool refused = ::setenv("GRPC_SSL_CIPHER_SUITES", "PSK-AES256-GCM-SHA384", /*replace=*/1) == 0;
  static_cast<void>(refused);
}

std::shared_ptr<grpc::experimental::CertificateProviderInterface> watch_files(const std::string& folder,
                                                                              std::chrono::seconds interval) {
  refuse_tls_1_2();
  return std::make_shared<grpc::experimental::FileWatcherCertificateProvider>(
      path_of(folder, kKeyFile), path_of(folder, kCertificateFile), path_of(folder, kTrustedFile),
      static_cast<unsigned>(interval.count()));
}

}  // namespace

absl::Status check_certificates(const std::string& folder) {
  Certificate trusted, certificate;
  Key key;
  const std::string trusted_path = path_of(folder, kTrustedFile);
  if (auto s = read_certificate(trusted_path, trusted); !s.ok()) return s;
  const std::string path = path_of(folder, kCertificateFile);
  if (auto s = read_certificate(path, certificate); !s.ok()) return s;
  const std::string key_path = path_of(folder, kKeyFile);
  if (auto s = read_pem(key_path,
                        [&](std::FILE* file) {
                          // Without a function for the passphrase, OpenSSL would ask for it on the terminal.
                          const auto no_passphrase = [](char*, int, int, void*) { return -1; };
                          key.reset(PEM_read_PrivateKey(file, nullptr, no_passphrase, nullptr));
                          return key != nullptr;
                        });
      !s.ok()) {
    return s;
  }
  if (X509_check_private_key(certificate.get(), key.get()) != 1) {
    ERR_clear_error();
    return absl::InvalidArgumentError(absl::StrCat(key_path, " is not the key of ", path));
  }
  return check_signed(text_of(trusted_path), certificate.get(), path);
}

std::shared_ptr<grpc::ChannelCredentials> channel_credentials(const std::string& folder) {
  grpc::experimental::TlsChannelCredentialsOptions options;
  options.set_certificate_provider(watch_files(folder, kCertificateInterval));
  options.watch_root_certs();
  options.watch_identity_key_cert_pairs();
  return grpc::experimental::TlsCredentials(options);
}

std::shared_ptr<grpc::ServerCredentials> server_credentials(const std::string& folder,
                                                            std::chrono::seconds interval) {
  grpc::experimental::TlsServerCredentialsOptions options{watch_files(folder, interval)};
  options.watch_root_certs();
  options.watch_identity_key_cert_pairs();
  options.set_cert_request_type(GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
  return grpc::experimental::TlsServerCredentials(options);
}

std::shared_ptr<grpc::ServerCredentials> open_server_credentials(const std::string& folder,
                                                                 std::chrono::seconds interval) {
  grpc::experimental::TlsServerCredentialsOptions options{watch_files(folder, interval)};
  options.watch_identity_key_cert_pairs();
  options.set_cert_request_type(GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE);
  return grpc::experimental::TlsServerCredentials(options);
}

std::shared_ptr<grpc::ChannelCredentials> trusting_credentials(const std::string& authority_pem) {
  refuse_tls_1_2();
  return grpc::SslCredentials({.pem_root_certs = authority_pem, .pem_private_key = "", .pem_cert_chain = ""});
}

std::shared_ptr<grpc::ChannelCredentials> unverified_credentials() {
  refuse_tls_1_2();
  grpc::experimental::TlsChannelCredentialsOptions options;
  options.set_verify_server_certs(false);
  options.set_certificate_verifier(std::make_shared<grpc::experimental::NoOpCertificateVerifier>());
  options.set_check_call_host(false);
  return grpc::experimental::TlsCredentials(options);
}

}  // namespace tessera::net
