// Encryption between the programs: mutual TLS 1.3, with certificates from files that may be renewed while
// programs run.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "absl/status/status.h"

namespace grpc {
class ChannelCredentials;
class ServerCredentials;
}  // namespace grpc

namespace tessera::net {

// Files in the folder of one program, as PEM: who it trusts, who it is, and the key that proves that.
inline constexpr const char* kTrustedFile = "ca.pem";
inline constexpr const char* kCertificateFile = "certificate.pem";
inline constexpr const char* kKeyFile = "key.pem";

/// Why TLS cannot be spoken with the certificates of `folder`: NotFound (a file is missing or cannot be
/// read), InvalidArgument (not PEM, or key and certificate do not belong together, or the authority did not
/// sign it), FailedPrecondition (expired, or not valid yet).
absl::Status check_certificates(const std::string& folder);

/// How often the files are looked at.
inline constexpr std::chrono::seconds kCertificateInterval{10};

/// The other end must have a certificate of the folder's authority; a server's must name the host that was
/// called.
std::shared_ptr<grpc::ChannelCredentials> channel_credentials(const std::string& folder);
std::shared_ptr<grpc::ServerCredentials> server_credentials(
    const std::string& folder, std::chrono::seconds interval = kCertificateInterval);

// For a worker that has no certificate yet (join_token.h).

/// The server shows its certificate, and asks for none. What is served under these must not be for members of
/// the farm only.
std::shared_ptr<grpc::ServerCredentials> open_server_credentials(
    const std::string& folder, std::chrono::seconds interval = kCertificateInterval);
/// The server must have a certificate of this authority that names the host that was called.
std::shared_ptr<grpc::ChannelCredentials> trusting_credentials(const std::string& authority_pem);
/// Anybody may be at the other end: for what is public, and is checked by other means.
std::shared_ptr<grpc::ChannelCredentials> unverified_credentials();

}  // namespace tessera::net
