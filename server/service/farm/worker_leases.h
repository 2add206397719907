// The units that workers have in their hands.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "service/farm/done.h"
#include "service/farm/lease_uploads.h"
#include "service/farm/worker_origin.h"
#include "tessera/v1/blob.pb.h"
#include "tessera/v1/work.pb.h"

namespace tessera::server {

class FarmCore;
class LeaseSeal;
class WorkerRegistry;

/// All calls: NotFound as WorkerRegistry::check has it, Unavailable when the farm stops. Thread-safe. The
/// other parts must outlive it.
class WorkerLeases {
 public:
  WorkerLeases(FarmCore& core, WorkerRegistry& workers) : core_(core), workers_(workers) {}

  /// Answers when there is work, after the wait asked for, or with nothing when `cancelled` turned true.
  /// ResourceExhausted for a request that names too much.
  void lease(v1::LeaseRequest request, const WorkerOrigin& origin, std::function<bool()> cancelled,
             Done<v1::LeaseResponse> done);
  /// ResourceExhausted for too many leases.
  absl::StatusOr<v1::HeartbeatResponse> heartbeat(const v1::HeartbeatRequest& request,
                                                  const WorkerOrigin& origin = {});
  /// A worker begins to upload a blob, or goes on with it, as BlobService.Upload has it. It counts against
  /// the worker's identity until a result names it.
  absl::Status begin_unit_upload(const v1::UploadRequest& first, const WorkerOrigin& origin);

  /// Whether the request names no more jobs and scenes than a call that waits may hold.
  static bool names_few(const v1::LeaseRequest& request);

  // With the farm's lock held.

  /// Grants what is to be had now.
  absl::StatusOr<v1::LeaseResponse> grant(const std::string& worker, const v1::LeaseRequest& request);
  /// A heartbeat, whatever brought it.
  absl::StatusOr<v1::HeartbeatResponse> beat(const std::string& worker, const v1::HeartbeatRequest& request);
  /// FailedPrecondition for a lease that was never granted to the host of this worker.
  absl::Status check_granted(const std::string& worker, const v1::LeaseToken& token) const;
  /// A result that counts names the blob.
  void claim_upload(const std::string& digest) { uploads_.claim(digest); }
  /// Blobs that were uploaded a while ago, and that no result has named; they are forgotten.
  std::vector<std::string> take_old_uploads();

 private:
  /// Tries once; true when the call was answered.
  bool try_lease(const v1::LeaseRequest& request, bool last, const Done<v1::LeaseResponse>& done);
  const LeaseSeal& seal() const;

  FarmCore& core_;
  WorkerRegistry& workers_;
  LeaseUploads uploads_;
};

}  // namespace tessera::server
