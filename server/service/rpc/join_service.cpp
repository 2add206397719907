#include "service/rpc/join_service.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "base/address.h"
#include "net/join_token.h"
#include "net/tls.h"
#include "net/x509.h"
#include "scheduler/identity.h"
#include "service/rpc/access.h"
#include "service/rpc/answer.h"
#include "telemetry/log.h"
#include "tls/expelled.h"

namespace tessera::server {
namespace {

using WallClock = std::chrono::system_clock;

// Requests are small, and so is what strangers may take of the coordinator.
constexpr int kMaxMessageBytes = 16 << 10;
constexpr int kMaxJoinStreams = 4;
constexpr std::size_t kMaxMemoryBytes = std::size_t{64} << 20;
constexpr int kMaxThreads = 4;
constexpr std::size_t kMaxRequestBytes = 4096;
constexpr std::size_t kMaxSecretBytes = 128;
constexpr int kMaxConnectionAgeMs = 30'000;
using ConnectionType = grpc::ServerBuilder::experimental_type::ExternalConnectionType;
constexpr std::chrono::seconds kJoinGrace{1};

/// "ipv4:10.0.0.1:4711" without the port: whom wrong tokens are counted against.
std::string address_of(const std::string& peer) { return peer.substr(0, peer.rfind(':')); }

}  // namespace

class JoinServer::Service final : public v1::JoinService::CallbackService {
 public:
  explicit Service(JoinServer& server) : server_(server) {}

  grpc::ServerUnaryReactor* GetAuthority(grpc::CallbackServerContext* context, const v1::GetAuthorityRequest*,
                                         v1::GetAuthorityResponse* response) override {
    response->set_certificate_pem(server_.authority()->certificate_pem());
    return answer(context->DefaultReactor(), absl::OkStatus());
  }

  grpc::ServerUnaryReactor* Join(grpc::CallbackServerContext* context, const v1::JoinRequest* request,
                                 v1::JoinResponse* response) override {
    absl::StatusOr<std::string> certificate = server_.join(*request, context->peer());
    if (!certificate.ok()) return answer(context->DefaultReactor(), certificate.status());
    response->set_certificate_pem(*std::move(certificate));
    return answer(context->DefaultReactor(), absl::OkStatus());
  }

 private:
  JoinServer& server_;
};

JoinServer::JoinServer(const JoinOptions& options, Authority authority, const Written& read,
                       JoinTokens tokens)
    : authority_folder_(options.authority),
      certificates_(options.certificates),
      authority_(std::make_shared<const Authority>(std::move(authority))),
      read_(read),
      tokens_(std::move(tokens)),
      members_(options.members),
      service_(std::make_unique<Service>(*this)) {}

JoinServer::Written JoinServer::written(const std::filesystem::path& folder) {
  std::error_code error;
  return {.key = std::filesystem::last_write_time(folder / net::kKeyFile, error),
          .certificate = std::filesystem::last_write_time(folder / net::kTrustedFile, error)};
}

std::shared_ptr<const Authority> JoinServer::authority() {
  const std::lock_guard lock(mutex_);
  const Written now = written(authority_folder_);
  if (now == read_) return authority_;
  // Files are replaced one after the other: what does not fit yet is looked at again.
  absl::StatusOr<Authority> other = Authority::open_existing(authority_folder_);
  if (!other.ok() || !other->is_trusted_by(certificates_)) return authority_;
  authority_ = std::make_shared<const Authority>(*std::move(other));
  read_ = now;
  spdlog::info("workers that join get certificates of a new authority");
  return authority_;
}

absl::StatusOr<std::unique_ptr<JoinServer>> JoinServer::start(const JoinOptions& options,
                                                              Connections& connections) {
  const absl::StatusOr<base::HostPort> address = base::parse_host_port(options.address);
  if (!address.ok()) return address.status();
  const Written read = written(options.authority);
  absl::StatusOr<Authority> authority = Authority::open_existing(options.authority);
  if (!authority.ok()) return authority.status();
  if (!authority->is_trusted_by(options.certificates)) {
    return absl::InvalidArgumentError(absl::StrCat("the authority in ", options.authority.string(),
                                                   " is not the one that ", options.certificates, " trusts"));
  }
  absl::StatusOr<JoinTokens> tokens = JoinTokens::open(options.token_file);
  if (!tokens.ok()) return tokens.status();

  std::unique_ptr<JoinServer> server{
      new JoinServer{options, *std::move(authority), read, *std::move(tokens)}};
  const auto credentials = net::open_server_credentials(options.certificates, options.certificate_interval);
  credentials->SetAuthMetadataProcessor(access_to_joining());
  grpc::ServerBuilder builder;
  builder.RegisterService(server->service_.get());
  builder.SetMaxReceiveMessageSize(kMaxMessageBytes);
  builder.SetResourceQuota(grpc::ResourceQuota{"joining"}.Resize(kMaxMemoryBytes).SetMaxThreads(kMaxThreads));
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kMaxJoinStreams);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_AGE_MS, kMaxConnectionAgeMs);
  auto listener = Listener::open(*address, connections, Connections::Port::kStrangers);
  if (!listener.ok()) return listener.status();
  server->listener_ = *std::move(listener);
  Listener::Acceptor acceptor =
      builder.experimental().AddExternalConnectionAcceptor(ConnectionType::FROM_FD, credentials);
  server->server_ = builder.BuildAndStart();
  if (server->server_ == nullptr) return absl::InternalError("gRPC does not start a server");
  server->listener_->start(std::move(acceptor));
  return server;
}

JoinServer::~JoinServer() {
  if (server_ == nullptr) return;
  listener_->stop();
  server_->Shutdown(WallClock::now() + kJoinGrace);
  server_->Wait();
}

absl::StatusOr<std::string> JoinServer::make_token(std::chrono::seconds life, std::uint32_t uses) {
  absl::StatusOr<std::string> secret = tokens_.make(life, uses, WallClock::now());
  if (!secret.ok()) return secret.status();
  return net::JoinToken{.port = static_cast<std::uint16_t>(port()),
                        .authority_digest = authority()->digest(),
                        .secret = *std::move(secret)}
      .to_string();
}

absl::StatusOr<std::string> JoinServer::name_for(const v1::JoinRequest& request) const {
  const net::CertificateRequest asked = net::request_from_pem(request.request_pem());
  if (asked == nullptr) return absl::InvalidArgumentError("this is no request for a certificate in PEM");
  const std::string key = net::key_digest_of(asked.get());
  // Somebody may have looked for a key whose first digits are another's.
  std::size_t digits = kShownDigits;
  const auto name_with = [&] {
    return absl::StrCat(request.name().substr(0, Expelled::kLongestName - 1 - digits), "@",
                        key.substr(0, digits));
  };
  while (digits < kFingerprintDigits && members_->has_seen(Role::kWorker, name_with())) digits *= 2;
  return request.name().empty() ? absl::InvalidArgumentError("the machine has no name")
                                : absl::StatusOr<std::string>{name_with()};
}

absl::StatusOr<std::string> JoinServer::join(const v1::JoinRequest& request, const std::string& peer) {
  if (request.secret().size() > kMaxSecretBytes || request.request_pem().size() > kMaxRequestBytes) {
    return absl::InvalidArgumentError("the secret or the request is too long");
  }
  const auto now = WallClock::now();
  const absl::StatusOr<std::string> name = name_for(request);
  if (!name.ok()) return name.status();
  // Made before the token is used up, handed out only after.
  absl::StatusOr<std::string> certificate =
      authority()->certify(request.request_pem(), {.role = Role::kWorker, .name = *name, .hosts = {}},
                           now - kClockSlack, now + kCertificateLife);
  if (!certificate.ok()) return certificate.status();
  const absl::Status redeemed = tokens_.redeem(request.secret(), *name, address_of(peer), now);
  const telemetry::LogFields fields{.worker = *name, .peer = peer};
  if (redeemed.ok()) {
    telemetry::log(spdlog::level::info, fields, "worker {} joined the farm", *name);
    members_->note(Role::kWorker, *name);
    return certificate;
  }
  if (absl::IsResourceExhausted(redeemed)) return redeemed;  // the lines before this one tell enough
  telemetry::log(spdlog::level::warn, fields, "worker {} may not join: {}", request.name(),
                 std::string(redeemed.message()));
  if (absl::IsPermissionDenied(redeemed)) {
    return absl::PermissionDeniedError("the join token is not valid: wrong, expired, or used up");
  }
  return redeemed;
}

}  // namespace tessera::server
