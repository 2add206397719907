#include "service/farm_service.h"

#include "service/answer.h"
#include "service/watch_reactor.h"

namespace tessera::server {

grpc::ServerUnaryReactor* FarmService::SubmitJob(grpc::CallbackServerContext* context,
                                                 const v1::SubmitJobRequest* request, v1::SubmitJobResponse* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  farm_.submit(*request, [reactor, response](const absl::StatusOr<std::string>& id) {
    if (id.ok()) response->set_job_id(*id);
    answer(reactor, id.status());
  });
  return reactor;
}

grpc::ServerUnaryReactor* FarmService::GetJob(grpc::CallbackServerContext* context, const v1::GetJobRequest* request,
                                              v1::GetJobResponse* response) {
  return answer(context->DefaultReactor(), farm_.get_job(request->job_id()), response);
}

grpc::ServerUnaryReactor* FarmService::ListJobs(grpc::CallbackServerContext* context,
                                                const v1::ListJobsRequest* request, v1::ListJobsResponse* response) {
  *response = farm_.list_jobs();
  return answer(context->DefaultReactor(), absl::OkStatus());
}

grpc::ServerUnaryReactor* FarmService::CancelJob(grpc::CallbackServerContext* context,
                                                 const v1::CancelJobRequest* request, v1::CancelJobResponse* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  farm_.cancel(request->job_id(), [reactor, response](const absl::StatusOr<v1::JobStatus>& status) {
    if (status.ok()) *response->mutable_status() = *status;
    answer(reactor, status.status());
  });
  return reactor;
}

grpc::ServerUnaryReactor* FarmService::RetryJob(grpc::CallbackServerContext* context,
                                                const v1::RetryJobRequest* request, v1::RetryJobResponse* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  farm_.retry(request->job_id(), [reactor, response](const absl::StatusOr<v1::JobStatus>& status) {
    if (status.ok()) *response->mutable_status() = *status;
    answer(reactor, status.status());
  });
  return reactor;
}

grpc::ServerUnaryReactor* FarmService::AdjustJob(grpc::CallbackServerContext* context,
                                                 const v1::AdjustJobRequest* request, v1::AdjustJobResponse* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  farm_.adjust(*request, [reactor, response](const absl::StatusOr<v1::JobStatus>& status) {
    if (status.ok()) *response->mutable_status() = *status;
    answer(reactor, status.status());
  });
  return reactor;
}

grpc::ServerUnaryReactor* FarmService::TrustHost(grpc::CallbackServerContext* context,
                                                 const v1::TrustHostRequest* request, v1::TrustHostResponse* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  farm_.trust_host(request->host(), [reactor](const absl::Status& status) { answer(reactor, status); });
  return reactor;
}

grpc::ServerWriteReactor<v1::WatchJobResponse>* FarmService::WatchJob(grpc::CallbackServerContext* context,
                                                                      const v1::WatchJobRequest* request) {
  return watch_job(farm_, *request);
}

grpc::ServerUnaryReactor* FarmService::ListWorkers(grpc::CallbackServerContext* context,
                                                   const v1::ListWorkersRequest* request,
                                                   v1::ListWorkersResponse* response) {
  *response = farm_.list_workers();
  return answer(context->DefaultReactor(), absl::OkStatus());
}

}  // namespace tessera::server
