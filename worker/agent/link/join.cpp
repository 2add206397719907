#include "agent/link/join.h"

#include <grpcpp/grpcpp.h>

#include <chrono>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "base/address.h"
#include "base/private_file.h"
#include "net/call.h"
#include "net/channel.h"
#include "net/join_token.h"
#include "net/tls.h"
#include "net/x509.h"
#include "telemetry/log.h"
#include "tessera/v1/join.grpc.pb.h"

namespace tessera::agent {
namespace {

using Stub = v1::JoinService::Stub;

constexpr std::chrono::seconds kPatience{20};
constexpr std::chrono::seconds kFirstContact{5};  // for a coordinator that starts at the same time

/// One call over a connection of its own.
template <class Request, class Response>
absl::StatusOr<Response> call(const std::string& address,
                              const std::shared_ptr<grpc::ChannelCredentials>& credentials,
                              grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*),
                              const Request& request, const char* name) {
  const auto channel = grpc::CreateCustomChannel(address, credentials, net::channel_arguments());
  net::wait_for_connection(*channel, kFirstContact, std::stop_token{});
  const auto stub = v1::JoinService::NewStub(channel);
  return net::unary_call(*stub, method, request, name, address, kPatience, std::stop_token{});
}

/// The certificate of the token's authority, in PEM. Anybody may answer: what counts is its digest.
absl::StatusOr<std::string> fetch_authority(const std::string& address, const net::JoinToken& token) {
  const absl::StatusOr<v1::GetAuthorityResponse> response = call(
      address, net::unverified_credentials(), &Stub::GetAuthority, v1::GetAuthorityRequest{}, "GetAuthority");
  if (!response.ok()) return response.status();
  const net::Certificate certificate = net::certificate_from_pem(response->certificate_pem());
  if (certificate == nullptr || net::digest_of(certificate.get()) != token.authority_digest) {
    return absl::PermissionDeniedError(
        absl::StrCat(address, " is not of the farm that the join token is for: its authority is another"));
  }
  return net::to_pem(certificate.get());
}

}  // namespace

absl::Status join_farm(const JoinRequest& request) {
  if (net::check_certificates(request.certificate_folder.string()).ok()) {
    spdlog::info("{} holds certificates; nothing is to be joined", request.certificate_folder.string());
    return absl::OkStatus();
  }
  const absl::StatusOr<net::JoinToken> token = net::parse_join_token(request.token);
  if (!token.ok()) return token.status();
  absl::StatusOr<base::HostPort> server = base::parse_host_port(request.server);
  if (!server.ok()) return server.status();
  server->port = token->port;
  const std::string address = server->to_string();

  const absl::StatusOr<std::string> authority = fetch_authority(address, *token);
  if (!authority.ok()) return authority.status();

  // All that can fail here fails before the token is used.
  const net::Key key = net::make_key();
  const net::CertificateRequest certificate_request =
      key == nullptr ? nullptr : net::make_request(key.get(), request.machine_name);
  if (certificate_request == nullptr) return absl::InternalError("no key can be made");
  if (auto s = base::make_folder(request.certificate_folder); !s.ok()) return s;
  if (auto s = base::replace_file(request.certificate_folder / net::kKeyFile, 0600, net::to_pem(key.get()));
      !s.ok())
    return s;
  if (auto s = base::replace_file(request.certificate_folder / net::kTrustedFile, 0644, *authority); !s.ok())
    return s;

  v1::JoinRequest join;
  join.set_secret(token->secret);
  join.set_name(request.machine_name);
  join.set_request_pem(net::to_pem(certificate_request.get()));
  const absl::StatusOr<v1::JoinResponse> joined =
      call(address, net::trusting_credentials(*authority), &Stub::Join, join, "Join");
  if (!joined.ok()) return joined.status();
  if (auto s = base::replace_file(request.certificate_folder / net::kCertificateFile, 0644,
                                  joined->certificate_pem());
      !s.ok()) {
    return s;
  }
  if (auto s = net::check_certificates(request.certificate_folder.string()); !s.ok()) return s;
  spdlog::info("joined the farm of {}: certificates are in {}", request.server,
               request.certificate_folder.string());
  return absl::OkStatus();
}

}  // namespace tessera::agent
