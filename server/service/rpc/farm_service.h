// FarmService: clients.
#pragma once

#include <grpcpp/grpcpp.h>

#include <string>

#include "absl/status/statusor.h"
#include "service/farm/rights.h"
#include "tessera/v1/farm.grpc.pb.h"

namespace tessera::server {

class Expelled;
class Farm;
class JoinServer;
class Members;
class OpenStreams;
class WebSite;

/// Where the web page is.
struct WebPort {
  std::string address;  // HOST:PORT
  WebSite* site;
};

/// Farm, streams, lists of the expelled and of members, and joining must outlive the service. Where callers
/// are known by their certificates, each sees and changes its own jobs, administrators all; `share_jobs`:
/// everybody all.
class FarmService final : public v1::FarmService::CallbackService {
 public:
  /// `joining` may be null: no workers join; so may `web`: there is no web page.
  FarmService(Farm& farm, OpenStreams& streams, Expelled& expelled, const Members& members,
              JoinServer* joining, const WebPort* web, bool share_jobs);

  grpc::ServerUnaryReactor* SubmitJob(grpc::CallbackServerContext* context,
                                      const v1::SubmitJobRequest* request,
                                      v1::SubmitJobResponse* response) override;
  grpc::ServerUnaryReactor* GetJob(grpc::CallbackServerContext* context, const v1::GetJobRequest* request,
                                   v1::GetJobResponse* response) override;
  grpc::ServerUnaryReactor* ListJobs(grpc::CallbackServerContext* context, const v1::ListJobsRequest* request,
                                     v1::ListJobsResponse* response) override;
  grpc::ServerUnaryReactor* CancelJob(grpc::CallbackServerContext* context,
                                      const v1::CancelJobRequest* request,
                                      v1::CancelJobResponse* response) override;
  grpc::ServerUnaryReactor* DeleteJob(grpc::CallbackServerContext* context,
                                      const v1::DeleteJobRequest* request,
                                      v1::DeleteJobResponse* response) override;
  grpc::ServerUnaryReactor* RetryJob(grpc::CallbackServerContext* context, const v1::RetryJobRequest* request,
                                     v1::RetryJobResponse* response) override;
  grpc::ServerUnaryReactor* AdjustJob(grpc::CallbackServerContext* context,
                                      const v1::AdjustJobRequest* request,
                                      v1::AdjustJobResponse* response) override;
  grpc::ServerUnaryReactor* TrustHost(grpc::CallbackServerContext* context,
                                      const v1::TrustHostRequest* request,
                                      v1::TrustHostResponse* response) override;
  grpc::ServerUnaryReactor* MakeJoinToken(grpc::CallbackServerContext* context,
                                          const v1::MakeJoinTokenRequest* request,
                                          v1::MakeJoinTokenResponse* response) override;
  grpc::ServerUnaryReactor* MakeWebToken(grpc::CallbackServerContext* context,
                                         const v1::MakeWebTokenRequest* request,
                                         v1::MakeWebTokenResponse* response) override;
  grpc::ServerUnaryReactor* Expel(grpc::CallbackServerContext* context, const v1::ExpelRequest* request,
                                  v1::ExpelResponse* response) override;
  grpc::ServerWriteReactor<v1::WatchJobResponse>* WatchJob(grpc::CallbackServerContext* context,
                                                           const v1::WatchJobRequest* request) override;
  grpc::ServerUnaryReactor* ListWorkers(grpc::CallbackServerContext* context,
                                        const v1::ListWorkersRequest* request,
                                        v1::ListWorkersResponse* response) override;

 private:
  /// NotFound for a job that is not there, PermissionDenied for one that is not the caller's.
  absl::Status check_access(const grpc::CallbackServerContext& context, const std::string& job) const;

  absl::StatusOr<v1::ExpelResponse> expel(const v1::ExpelRequest& request, const grpc::AuthContext* by);

  Farm& farm_;
  OpenStreams& streams_;
  Expelled& expelled_;
  const Members& members_;
  JoinServer* const joining_;
  const WebPort* const web_;
  const Rights rights_;
};

}  // namespace tessera::server
