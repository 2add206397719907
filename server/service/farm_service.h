// FarmService: clients.
#pragma once

#include <grpcpp/grpcpp.h>

#include "service/farm.h"
#include "tessera/v1/farm.grpc.pb.h"

namespace tessera::server {

/// The farm must outlive the service.
class FarmService final : public v1::FarmService::CallbackService {
 public:
  explicit FarmService(Farm& farm) : farm_(farm) {}

  grpc::ServerUnaryReactor* SubmitJob(grpc::CallbackServerContext* context, const v1::SubmitJobRequest* request,
                                      v1::SubmitJobResponse* response) override;
  grpc::ServerUnaryReactor* GetJob(grpc::CallbackServerContext* context, const v1::GetJobRequest* request,
                                   v1::GetJobResponse* response) override;
  grpc::ServerUnaryReactor* ListJobs(grpc::CallbackServerContext* context, const v1::ListJobsRequest* request,
                                     v1::ListJobsResponse* response) override;
  grpc::ServerUnaryReactor* CancelJob(grpc::CallbackServerContext* context, const v1::CancelJobRequest* request,
                                      v1::CancelJobResponse* response) override;
  grpc::ServerUnaryReactor* RetryJob(grpc::CallbackServerContext* context, const v1::RetryJobRequest* request,
                                     v1::RetryJobResponse* response) override;
  grpc::ServerUnaryReactor* AdjustJob(grpc::CallbackServerContext* context, const v1::AdjustJobRequest* request,
                                      v1::AdjustJobResponse* response) override;
  grpc::ServerUnaryReactor* TrustHost(grpc::CallbackServerContext* context, const v1::TrustHostRequest* request,
                                      v1::TrustHostResponse* response) override;
  grpc::ServerWriteReactor<v1::WatchJobResponse>* WatchJob(grpc::CallbackServerContext* context,
                                                           const v1::WatchJobRequest* request) override;
  grpc::ServerUnaryReactor* ListWorkers(grpc::CallbackServerContext* context, const v1::ListWorkersRequest* request,
                                        v1::ListWorkersResponse* response) override;

 private:
  Farm& farm_;
};

}  // namespace tessera::server
