#include "farm/farm_client.h"

#include <grpcpp/channel.h>

#include <utility>

#include "base/printable.h"
#include "farm/stubs.h"
#include "net/call.h"
#include "net/channel.h"

namespace tessera::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds kCallTimeout = seconds{15};
// A status comes at least every second (farm.proto).
constexpr milliseconds kWatchStall = seconds{15};

}  // namespace

FarmClient::FarmClient(std::shared_ptr<grpc::Channel> channel, FarmClientOptions options)
    : channel_(channel),
      options_(options),
      stubs_(std::make_unique<Stubs>(
          Stubs{v1::FarmService::NewStub(channel), v1::BlobService::NewStub(channel)})),
      contact_(options.address, options.first_contact_patience, options.later_patience,
               std::move(options.notice), [channel](milliseconds delay, std::stop_token stop) {
                 return net::wait_for_connection(*channel, delay, std::move(stop));
               }) {}

FarmClient::~FarmClient() = default;

std::unique_ptr<FarmClient> FarmClient::another() const {
  return std::make_unique<FarmClient>(channel_, options_);
}

absl::StatusOr<std::string> FarmClient::submit(const v1::JobSpec& spec, const Reuse& reuse,
                                               std::stop_token stop) {
  v1::SubmitJobRequest request;
  request.set_request_id(reuse.request_id.empty() ? make_request_id() : reuse.request_id);
  *request.mutable_spec() = spec;
  request.set_continued(reuse.continued);
  request.set_fresh(reuse.fresh);
  auto response = contact_.retried(stop, [&] {
    return net::unary_call(*stubs_->farm, &v1::FarmService::Stub::SubmitJob, request, "SubmitJob",
                           contact_.address(), kCallTimeout, stop);
  });
  if (!response.ok()) return response.status();
  return response->job_id();
}

absl::StatusOr<v1::GetJobResponse> FarmClient::job(const std::string& job_id, std::stop_token stop) {
  v1::GetJobRequest request;
  request.set_job_id(job_id);
  return contact_.retried(stop, [&] {
    return net::unary_call(*stubs_->farm, &v1::FarmService::Stub::GetJob, request, "GetJob",
                           contact_.address(), kCallTimeout, stop);
  });
}

absl::StatusOr<std::vector<v1::JobStatus>> FarmClient::jobs(std::stop_token stop) {
  auto response = contact_.retried(stop, [&] {
    return net::unary_call(*stubs_->farm, &v1::FarmService::Stub::ListJobs, v1::ListJobsRequest{}, "ListJobs",
                           contact_.address(), kCallTimeout, stop);
  });
  if (!response.ok()) return response.status();
  return std::vector<v1::JobStatus>{response->jobs().begin(), response->jobs().end()};
}

absl::StatusOr<v1::JobStatus> FarmClient::cancel(const std::string& job_id, std::stop_token stop) {
  v1::CancelJobRequest request;
  request.set_job_id(job_id);
  auto response = contact_.retried(stop, [&] {
    return net::unary_call(*stubs_->farm, &v1::FarmService::Stub::CancelJob, request, "CancelJob",
                           contact_.address(), kCallTimeout, stop);
  });
  if (!response.ok()) return response.status();
  return response->status();
}

absl::Status FarmClient::delete_job(const std::string& job_id, std::stop_token stop) {
  v1::DeleteJobRequest request;
  request.set_job_id(job_id);
  return contact_
      .retried(stop,
               [&] {
                 return net::unary_call(*stubs_->farm, &v1::FarmService::Stub::DeleteJob, request,
                                        "DeleteJob", contact_.address(), kCallTimeout, stop);
               })
      .status();
}

absl::StatusOr<v1::JobStatus> FarmClient::retry(const std::string& job_id, std::stop_token stop) {
  v1::RetryJobRequest request;
  request.set_job_id(job_id);
  auto response = contact_.retried(stop, [&] {
    return net::unary_call(*stubs_->farm, &v1::FarmService::Stub::RetryJob, request, "RetryJob",
                           contact_.address(), kCallTimeout, stop);
  });
  if (!response.ok()) return response.status();
  return response->status();
}

absl::StatusOr<v1::JobStatus> FarmClient::adjust(const v1::AdjustJobRequest& request, std::stop_token stop) {
  auto response = contact_.retried(stop, [&] {
    return net::unary_call(*stubs_->farm, &v1::FarmService::Stub::AdjustJob, request, "AdjustJob",
                           contact_.address(), kCallTimeout, stop);
  });
  if (!response.ok()) return response.status();
  return response->status();
}

absl::Status FarmClient::trust(const std::string& host, std::stop_token stop) {
  v1::TrustHostRequest request;
  request.set_host(host);
  return contact_
      .retried(stop,
               [&] {
                 return net::unary_call(*stubs_->farm, &v1::FarmService::Stub::TrustHost, request,
                                        "TrustHost", contact_.address(), kCallTimeout, stop);
               })
      .status();
}

absl::StatusOr<std::string> FarmClient::make_join_token(std::chrono::seconds lifetime, std::uint32_t uses,
                                                        std::stop_token stop) {
  v1::MakeJoinTokenRequest request;
  request.mutable_lifetime()->set_seconds(lifetime.count());
  request.set_uses(uses);
  auto response = contact_.retried(stop, [&] {
    return net::unary_call(*stubs_->farm, &v1::FarmService::Stub::MakeJoinToken, request, "MakeJoinToken",
                           contact_.address(), kCallTimeout, stop);
  });
  if (!response.ok()) return response.status();
  return response->token();
}

absl::StatusOr<v1::MakeWebTokenResponse> FarmClient::make_web_token(std::chrono::seconds lifetime,
                                                                    std::stop_token stop) {
  v1::MakeWebTokenRequest request;
  request.mutable_lifetime()->set_seconds(lifetime.count());
  return contact_.retried(stop, [&] {
    return net::unary_call(*stubs_->farm, &v1::FarmService::Stub::MakeWebToken, request, "MakeWebToken",
                           contact_.address(), kCallTimeout, stop);
  });
}

absl::StatusOr<v1::ExpelResponse> FarmClient::expel(const v1::ExpelRequest& request, std::stop_token stop) {
  return contact_.retried(stop, [&] {
    return net::unary_call(*stubs_->farm, &v1::FarmService::Stub::Expel, request, "Expel", contact_.address(),
                           kCallTimeout, stop);
  });
}

absl::StatusOr<v1::ListWorkersResponse> FarmClient::members(std::stop_token stop) {
  return contact_.retried(stop, [&] {
    return net::unary_call(*stubs_->farm, &v1::FarmService::Stub::ListWorkers, v1::ListWorkersRequest{},
                           "ListWorkers", contact_.address(), kCallTimeout, stop);
  });
}

absl::StatusOr<std::vector<v1::WorkerStatus>> FarmClient::workers(std::stop_token stop) {
  const absl::StatusOr<v1::ListWorkersResponse> response = members(std::move(stop));
  if (!response.ok()) return response.status();
  return std::vector<v1::WorkerStatus>{response->workers().begin(), response->workers().end()};
}

absl::StatusOr<v1::JobStatus> FarmClient::watch(const std::string& job_id, const WatchHandlers& handlers,
                                                std::stop_token stop) {
  WatchProgress progress;
  while (true) {
    // Each attempt goes on after the last result that arrived.
    const absl::Status status = watch_once(job_id, handlers, progress, stop);
    if (!progress.handler_status.ok()) return progress.handler_status;
    if (std::exchange(progress.restarted, false)) continue;
    if (status.ok() && has_ended(progress.last.state())) return progress.last;
    const absl::Status broken =
        status.ok() ? absl::UnavailableError("WatchJob: the stream ended before the job") : status;
    if (absl::Status given_up = contact_.failed(broken, stop); !given_up.ok()) return given_up;
  }
}

absl::Status FarmClient::watch_once(const std::string& job_id, const WatchHandlers& handlers,
                                    WatchProgress& progress, std::stop_token stop) {
  v1::WatchJobRequest request;
  request.set_job_id(job_id);
  request.set_after(progress.after);
  request.set_status_only(!handlers.result);

  grpc::ClientContext context;
  std::stop_callback cancel{stop, [&context] { context.TryCancel(); }};
  net::StallGuard guard{context, kWatchStall};
  const auto reader = stubs_->farm->WatchJob(&context, request);
  v1::WatchJobResponse response;
  while (reader->Read(&response)) {
    guard.progress();
    contact_.succeeded();
    if (!progress.take(response, handlers)) break;
  }
  if (!progress.handler_status.ok() || progress.restarted) context.TryCancel();
  const grpc::Status status = reader->Finish();
  const std::string call = absl::StrCat("WatchJob at ", contact_.address());
  if (guard.stalled()) return absl::DeadlineExceededError(absl::StrCat(call, ": nothing came for 15 s"));
  return status.ok() ? absl::OkStatus() : net::from_grpc(status, call);
}

}  // namespace tessera::client
