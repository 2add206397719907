#include "service/rpc/farm_service.h"

#include <chrono>
#include <optional>

#include "absl/strings/str_cat.h"
#include "service/farm/farm.h"
#include "service/farm/farm_views.h"
#include "service/farm/job_control.h"
#include "service/farm/job_submission.h"
#include "service/farm/worker_registry.h"
#include "service/rpc/access.h"
#include "service/rpc/answer.h"
#include "service/rpc/join_service.h"
#include "service/rpc/open_streams.h"
#include "service/rpc/watch_reactor.h"
#include "service/web/web_site.h"
#include "telemetry/log.h"

namespace tessera::server {
namespace {

Caller caller(const grpc::CallbackServerContext& context) { return caller_of(context.auth_context().get()); }

/// The answer to a watcher that may not watch.
class RefusedWatch final : public grpc::ServerWriteReactor<v1::WatchJobResponse> {
 public:
  explicit RefusedWatch(const absl::Status& why) { Finish(net::to_grpc(why)); }
  void OnDone() override { delete this; }
};

}  // namespace

FarmService::FarmService(Farm& farm, OpenStreams& streams, Expelled& expelled, const Members& members,
                         JoinServer* joining, const WebPort* web, bool share_jobs)
    : farm_(farm),
      streams_(streams),
      expelled_(expelled),
      members_(members),
      joining_(joining),
      web_(web),
      rights_(farm.views(), share_jobs) {}

absl::Status FarmService::check_access(const grpc::CallbackServerContext& context,
                                       const std::string& job) const {
  return rights_.check(caller(context), context.peer(), job);
}

grpc::ServerUnaryReactor* FarmService::SubmitJob(grpc::CallbackServerContext* context,
                                                 const v1::SubmitJobRequest* request,
                                                 v1::SubmitJobResponse* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  if (const std::string& job = request->continued(); !job.empty()) {
    if (absl::Status s = check_access(*context, job); !s.ok()) return answer(reactor, s);
  }
  for (const std::string& job : request->spec().farm().after()) {
    if (absl::Status s = check_access(*context, job); !s.ok()) return answer(reactor, s);
  }
  v1::SubmitJobRequest own = *request;
  // Who submits is who the certificate says.
  const Caller who = caller(*context);
  if (who.role == Role::kClient) own.mutable_spec()->mutable_farm()->set_user(who.user);
  farm_.submission().submit(
      own,
      [reactor, response](const absl::StatusOr<std::string>& id) {
        if (id.ok()) response->set_job_id(*id);
        answer(reactor, id.status());
      },
      who);
  return reactor;
}

grpc::ServerUnaryReactor* FarmService::GetJob(grpc::CallbackServerContext* context,
                                              const v1::GetJobRequest* request,
                                              v1::GetJobResponse* response) {
  if (absl::Status s = check_access(*context, request->job_id()); !s.ok())
    return answer(context->DefaultReactor(), s);
  return answer(context->DefaultReactor(), farm_.views().get_job(request->job_id()), response);
}

grpc::ServerUnaryReactor* FarmService::ListJobs(grpc::CallbackServerContext* context,
                                                const v1::ListJobsRequest* request,
                                                v1::ListJobsResponse* response) {
  *response = rights_.jobs(caller(*context));
  return answer(context->DefaultReactor(), absl::OkStatus());
}

grpc::ServerUnaryReactor* FarmService::CancelJob(grpc::CallbackServerContext* context,
                                                 const v1::CancelJobRequest* request,
                                                 v1::CancelJobResponse* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  if (absl::Status s = check_access(*context, request->job_id()); !s.ok()) return answer(reactor, s);
  farm_.jobs().cancel(request->job_id(), [reactor, response](const absl::StatusOr<v1::JobStatus>& status) {
    if (status.ok()) *response->mutable_status() = *status;
    answer(reactor, status.status());
  });
  return reactor;
}

grpc::ServerUnaryReactor* FarmService::DeleteJob(grpc::CallbackServerContext* context,
                                                 const v1::DeleteJobRequest* request,
                                                 v1::DeleteJobResponse*) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  if (absl::Status s = check_access(*context, request->job_id()); !s.ok()) return answer(reactor, s);
  farm_.jobs().delete_job(request->job_id(),
                          [reactor](const absl::Status& status) { answer(reactor, status); });
  return reactor;
}

grpc::ServerUnaryReactor* FarmService::RetryJob(grpc::CallbackServerContext* context,
                                                const v1::RetryJobRequest* request,
                                                v1::RetryJobResponse* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  if (absl::Status s = check_access(*context, request->job_id()); !s.ok()) return answer(reactor, s);
  farm_.jobs().retry(
      request->job_id(),
      [reactor, response](const absl::StatusOr<v1::JobStatus>& status) {
        if (status.ok()) *response->mutable_status() = *status;
        answer(reactor, status.status());
      },
      caller(*context));
  return reactor;
}

grpc::ServerUnaryReactor* FarmService::AdjustJob(grpc::CallbackServerContext* context,
                                                 const v1::AdjustJobRequest* request,
                                                 v1::AdjustJobResponse* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  if (absl::Status s = check_access(*context, request->job_id()); !s.ok()) return answer(reactor, s);
  farm_.jobs().adjust(
      *request,
      [reactor, response](const absl::StatusOr<v1::JobStatus>& status) {
        if (status.ok()) *response->mutable_status() = *status;
        answer(reactor, status.status());
      },
      caller(*context));
  return reactor;
}

grpc::ServerUnaryReactor* FarmService::TrustHost(grpc::CallbackServerContext* context,
                                                 const v1::TrustHostRequest* request,
                                                 v1::TrustHostResponse* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  farm_.workers().trust_host(request->host(),
                             [reactor](const absl::Status& status) { answer(reactor, status); });
  return reactor;
}

grpc::ServerUnaryReactor* FarmService::MakeJoinToken(grpc::CallbackServerContext* context,
                                                     const v1::MakeJoinTokenRequest* request,
                                                     v1::MakeJoinTokenResponse* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  if (joining_ == nullptr) {
    return answer(reactor,
                  absl::FailedPreconditionError("no workers join here: tessera-server --join-authority"));
  }
  absl::StatusOr<std::string> token =
      joining_->make_token(std::chrono::seconds{request->lifetime().seconds()}, request->uses());
  if (!token.ok()) return answer(reactor, token.status());
  const std::string user = caller(*context).user;
  telemetry::log(spdlog::level::info, {.user = user}, "'{}' made a join token: {} uses within {} s", user,
                 request->uses(), request->lifetime().seconds());
  response->set_token(*std::move(token));
  return answer(reactor, absl::OkStatus());
}

grpc::ServerUnaryReactor* FarmService::MakeWebToken(grpc::CallbackServerContext* context,
                                                    const v1::MakeWebTokenRequest* request,
                                                    v1::MakeWebTokenResponse* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  if (web_ == nullptr)
    return answer(reactor, absl::FailedPreconditionError("there is no web page here: tessera-server --web"));
  response->set_address(web_->address);
  response->set_encrypted(web_->site->needs_login());
  if (!web_->site->needs_login()) return answer(reactor, absl::OkStatus());
  const Caller who = caller(*context);
  absl::StatusOr<std::string> token =
      web_->site->make_token({.caller = who, .certificate = certificate_of(*context->auth_context())},
                             std::chrono::seconds{request->lifetime().seconds()});
  if (!token.ok()) return answer(reactor, token.status());
  telemetry::log(spdlog::level::info, {.user = who.user}, "'{}' made a login token of the web page",
                 who.user);
  response->set_token(*std::move(token));
  return answer(reactor, absl::OkStatus());
}

absl::StatusOr<v1::ExpelResponse> FarmService::expel(const v1::ExpelRequest& request,
                                                     const grpc::AuthContext* by) {
  const Caller who = caller_of(by);
  const std::optional<Role> role = role_of_name(request.role());
  if (!who.role)
    return absl::FailedPreconditionError("callers have no certificates here, so nobody can be expelled");
  if (!role || role == Role::kServer) {
    return absl::InvalidArgumentError("expected the role of a worker, a client or an admin");
  }
  const std::string& name = request.name();
  if (request.undo()) {
    if (absl::Status status = expelled_.readmit(*role, name); !status.ok()) return status;
    telemetry::log(spdlog::level::warn, {.user = who.user}, "'{}' lets {} '{}' come back", who.user,
                   request.role(), name);
    return v1::ExpelResponse{};
  }
  absl::Status known = check_member_name(name);
  if (!request.unseen()) known.Update(members_.check_seen(*role, name));
  if (!known.ok()) return known;
  auto until = std::chrono::system_clock::now();
  if (role == who.role && name == who.user) {
    // A certificate that leaked is put out by the one that takes its place.
    const auto own = time_made(certificate_of(*by));
    if (!own) return absl::FailedPreconditionError("your own certificate does not say when it was made");
    until = *own - std::chrono::seconds{1};
  }
  if (absl::Status s = expelled_.expel(*role, name, until); !s.ok()) return s;
  telemetry::log(spdlog::level::warn, {.user = who.user}, "'{}' expelled {} '{}'", who.user, request.role(),
                 name);
  streams_.cut_off(*role, name);
  v1::ExpelResponse response;
  if (role != Role::kWorker) return response;
  response.set_workers(farm_.workers().expel(name));
  if (joining_ == nullptr) return response;
  const absl::StatusOr<std::size_t> tokens = joining_->call_tokens_back(name);
  if (tokens.ok()) response.set_join_tokens(static_cast<std::uint32_t>(*tokens));
  return tokens.ok() ? absl::StatusOr<v1::ExpelResponse>{response} : tokens.status();
}

grpc::ServerUnaryReactor* FarmService::Expel(grpc::CallbackServerContext* context,
                                             const v1::ExpelRequest* request, v1::ExpelResponse* response) {
  return answer(context->DefaultReactor(), expel(*request, context->auth_context().get()), response);
}

grpc::ServerWriteReactor<v1::WatchJobResponse>* FarmService::WatchJob(grpc::CallbackServerContext* context,
                                                                      const v1::WatchJobRequest* request) {
  if (absl::Status s = check_access(*context, request->job_id()); !s.ok()) return new RefusedWatch{s};
  return watch_job(farm_, streams_, context, *request);
}

grpc::ServerUnaryReactor* FarmService::ListWorkers(grpc::CallbackServerContext* context,
                                                   const v1::ListWorkersRequest* request,
                                                   v1::ListWorkersResponse* response) {
  *response = rights_.workers(caller(*context));
  return answer(context->DefaultReactor(), absl::OkStatus());
}

}  // namespace tessera::server
