// The client's calls to the coordinator.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "farm/contact.h"
#include "farm/job_calls.h"
#include "import/input/imported_scene.h"
#include "tessera/v1/farm.pb.h"

namespace grpc {
class Channel;
}

namespace tessera::client {

struct FarmClientOptions {
  std::string address;  // named in messages
  // How long the coordinator is waited for: before it was ever reached, and when it went away later.
  std::chrono::milliseconds first_contact_patience{5'000};
  std::chrono::milliseconds later_patience{120'000};
  // Told once a break that the connection is lost and once that it is back. For people.
  std::function<void(const std::string&)> notice = [](const std::string&) {};
};

/// Every call may be repeated safely, and is, while the error may go away by itself and patience lasts. All
/// calls end with Cancelled when `stop` is requested. Not thread-safe.
class FarmClient final : public JobCalls {
 public:
  FarmClient(std::shared_ptr<grpc::Channel> channel, FarmClientOptions options);
  ~FarmClient() override;

  /// A client over the same connection, for another thread.
  std::unique_ptr<FarmClient> another() const;

  /// Bytes sent, and how many there are to send.
  using UploadProgress = std::function<void(std::uint64_t sent, std::uint64_t total)>;

  /// Uploads those of `blobs` that the coordinator lacks, in 1 MiB chunks; after a break from where the
  /// stored part ends. `progress`, where there is one, is told after each. Returns the bytes sent. DataLoss
  /// when a blob's file has changed since it was imported, NotFound when it is gone.
  absl::StatusOr<std::uint64_t> upload(const std::vector<const SceneBlob*>& blobs, std::stop_token stop,
                                       const UploadProgress& progress = {});

  absl::StatusOr<std::string> submit(const v1::JobSpec& spec, const Reuse& reuse,
                                     std::stop_token stop) override;

  absl::StatusOr<v1::GetJobResponse> job(const std::string& job_id, std::stop_token stop) override;
  absl::StatusOr<std::vector<v1::JobStatus>> jobs(std::stop_token stop) override;
  absl::StatusOr<v1::JobStatus> cancel(const std::string& job_id, std::stop_token stop) override;
  /// Forgets a job that is over, and its results. FailedPrecondition when it is not over.
  absl::Status delete_job(const std::string& job_id, std::stop_token stop);
  /// Units that were set aside are tried again. FailedPrecondition when the job ended otherwise than
  /// incomplete.
  absl::StatusOr<v1::JobStatus> retry(const std::string& job_id, std::stop_token stop);
  /// Pauses, resumes, changes the priority. FailedPrecondition when the job is over.
  absl::StatusOr<v1::JobStatus> adjust(const v1::AdjustJobRequest& request, std::stop_token stop);
  /// Lifts the quarantine of a host. NotFound for one that the coordinator does not know.
  absl::Status trust(const std::string& host, std::stop_token stop);
  /// With which `uses` workers may join the farm in that time. FailedPrecondition when the coordinator takes
  /// no joins.
  absl::StatusOr<std::string> make_join_token(std::chrono::seconds lifetime, std::uint32_t uses,
                                              std::stop_token stop);
  /// Where the coordinator's web page is, and with which token the caller logs in there in that time.
  /// FailedPrecondition when it has none.
  absl::StatusOr<v1::MakeWebTokenResponse> make_web_token(std::chrono::seconds lifetime,
                                                          std::stop_token stop);
  /// Puts whoever has such a certificate out of the farm, or, with `undo`, lets them in again.
  /// FailedPrecondition where callers have no certificates; NotFound when there is nothing to undo, or nobody
  /// of that name ever called.
  absl::StatusOr<v1::ExpelResponse> expel(const v1::ExpelRequest& request, std::stop_token stop);
  absl::StatusOr<std::vector<v1::WorkerStatus>> workers(std::stop_token stop);
  /// The same, with what the coordinator says of itself.
  absl::StatusOr<v1::ListWorkersResponse> members(std::stop_token stop);

  /// Over any number of breaks of the connection and restarts of the coordinator.
  absl::StatusOr<v1::JobStatus> watch(const std::string& job_id, const WatchHandlers& handlers,
                                      std::stop_token stop) override;

 private:
  struct Stubs;

  absl::StatusOr<std::vector<v1::BlobRef>> find_missing(const std::vector<const SceneBlob*>& blobs,
                                                        std::stop_token stop);
  /// Is told how many bytes of a blob were sent so far.
  using Sent = std::function<void(std::uint64_t)>;
  absl::StatusOr<std::uint64_t> upload_blob(const SceneBlob& blob, const Sent& told, std::stop_token stop);
  absl::Status watch_once(const std::string& job_id, const WatchHandlers& handlers, WatchProgress& progress,
                          std::stop_token stop);

  const std::shared_ptr<grpc::Channel> channel_;
  const FarmClientOptions options_;
  std::unique_ptr<Stubs> stubs_;
  Contact contact_;
};

}  // namespace tessera::client
