#include "service/rpc/access.h"

#include <grpc/grpc_security_constants.h>
#include <grpcpp/security/auth_metadata_processor.h>

#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "telemetry/line_limit.h"
#include "telemetry/log.h"

namespace tessera::server {
namespace {

std::string text_of(grpc::string_ref text) { return {text.data(), text.size()}; }

using Metadata = grpc::AuthMetadataProcessor::InputMetadata;

std::string method_of(const Metadata& metadata) {
  const auto path = metadata.find(":path");
  return path == metadata.end() ? "" : text_of(path->second);
}

class AccessByRole final : public grpc::AuthMetadataProcessor {
 public:
  AccessByRole(std::shared_ptr<const Expelled> expelled, std::shared_ptr<Members> members)
      : expelled_(std::move(expelled)), members_(std::move(members)) {}

  bool IsBlocking() const override { return false; }

  grpc::Status Process(const InputMetadata& metadata, grpc::AuthContext* context, OutputMetadata*,
                       OutputMetadata*) override {
    const std::string method = method_of(metadata);
    const Caller caller = caller_of(context);
    if (caller.role && expelled_->refuses(*caller.role, caller.user, certificate_of(*context)))
      return refuse_expelled(caller, method);
    if (caller.role && is_allowed(*caller.role, method)) {
      members_->note(*caller.role, caller.user);
      return grpc::Status::OK;
    }
    const std::string who = caller.role ? absl::StrCat("'", caller.user, "' (", to_string(*caller.role), ")")
                                        : absl::StrCat("'", caller.user, "' (a certificate without a role)");
    telemetry::log(spdlog::level::warn, {.user = caller.user}, "refused: {} called {}", who, method);
    return {grpc::StatusCode::PERMISSION_DENIED, absl::StrCat(method, " is not for ", who)};
  }

 private:
  grpc::Status refuse_expelled(const Caller& caller, const std::string& method) {
    const std::string who = absl::StrCat("'", caller.user, "' (", to_string(*caller.role), ")");
    if (const auto [write, left_out] = expelled_calls_.count(); write) {
      telemetry::log(spdlog::level::warn, {.user = caller.user},
                     "refused: {}, who is expelled, called {} ({} such lines left out before)", who, method,
                     left_out);
    }
    return {grpc::StatusCode::PERMISSION_DENIED,
            absl::StrCat(who,
                         " was expelled from the farm: a new certificate is "
                         "needed")};
  }

  const std::shared_ptr<const Expelled> expelled_;
  const std::shared_ptr<Members> members_;
  telemetry::LineLimit expelled_calls_;  // a machine that was taken over may call as often as it likes
};

class AccessToJoining final : public grpc::AuthMetadataProcessor {
 public:
  bool IsBlocking() const override { return false; }

  grpc::Status Process(const InputMetadata& metadata, grpc::AuthContext*, OutputMetadata*,
                       OutputMetadata*) override {
    const std::string method = method_of(metadata);
    if (absl::StartsWith(method, "/tessera.v1.JoinService/")) return grpc::Status::OK;
    if (const auto [write, left_out] = limit_.count(); write) {
      spdlog::warn("refused: somebody without a certificate called {} ({} such lines left out before)",
                   method, left_out);
    }
    return {grpc::StatusCode::PERMISSION_DENIED, absl::StrCat(method, " is not served here")};
  }

 private:
  telemetry::LineLimit limit_;  // whoever reaches the port may call
};

}  // namespace

Caller caller_of(const grpc::AuthContext* context) {
  Caller caller;
  if (context == nullptr) return caller;
  for (const grpc::string_ref& uri : context->FindPropertyValues(GRPC_PEER_URI_PROPERTY_NAME)) {
    if (const auto role = role_of_uri({uri.data(), uri.size()})) caller.role = role;
  }
  for (const grpc::string_ref& name : context->FindPropertyValues(GRPC_X509_CN_PROPERTY_NAME))
    caller.user = text_of(name);
  return caller;
}

std::string certificate_of(const grpc::AuthContext& context) {
  const std::vector<grpc::string_ref> pem = context.FindPropertyValues(GRPC_X509_PEM_CERT_PROPERTY_NAME);
  return pem.empty() ? "" : text_of(pem.front());
}

std::shared_ptr<grpc::AuthMetadataProcessor> access_by_role(std::shared_ptr<const Expelled> expelled,
                                                            std::shared_ptr<Members> members) {
  return std::make_shared<AccessByRole>(std::move(expelled), std::move(members));
}
std::shared_ptr<grpc::AuthMetadataProcessor> access_to_joining() {
  return std::make_shared<AccessToJoining>();
}

}  // namespace tessera::server
