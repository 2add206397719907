// Shares that users take of the farm, and whether they are too large.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "service/farm/caller.h"
#include "service/farm/quotas.h"
#include "service/farm/unclaimed_uploads.h"
#include "tessera/v1/job.pb.h"

namespace tessera::server {

class FarmCore;
struct JobEntry;
struct JobShape;

/// Jobs, their blobs, and uploads that no job has named yet, held against the farm's Quotas. Thread-safe. The
/// core must outlive it.
class UserShares {
 public:
  explicit UserShares(FarmCore& core);

  /// A client begins to upload a blob, or goes on with it: its bytes count against the client until a job
  /// names it. ResourceExhausted.
  absl::Status begin_upload(const v1::BlobRef& blob, const Caller& by);
  /// A blob was uploaded, so the next job that refers to it is told what it cost.
  void note_upload(const std::string& digest, std::uint64_t bytes);

  /// PermissionDenied for a priority that is too high for the caller.
  absl::Status check_priority(const Caller& by, std::int32_t priority) const;

  // With the farm's lock held.

  /// Whether the job's user may have it; its blobs have these sizes. ResourceExhausted.
  absl::Status check_new_job(const Caller& by, const JobShape& shape,
                             const std::vector<std::uint64_t>& blob_sizes) const;
  /// Whether `by` may have the job opened again, which is over. PermissionDenied, ResourceExhausted.
  absl::Status check_reopening(const Caller& by, const JobEntry& entry) const;
  /// Returns what the job's blobs cost, each told once.
  std::uint64_t claim_uploads(const v1::JobSpec& spec) { return uploads_.claim(spec); }
  /// No job will be told what this blob cost.
  void forget_upload(const std::string& digest) { uploads_.forget(digest); }

 private:
  const Quotas& quotas() const;
  UserShare share_of(const std::string& user) const;

  FarmCore& core_;
  UnclaimedUploads uploads_;
};

}  // namespace tessera::server
