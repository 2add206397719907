// How a job comes to the farm, and what it takes over from others.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "service/farm/caller.h"
#include "service/farm/done.h"
#include "service/job/adoption.h"
#include "tessera/v1/farm.pb.h"

namespace tessera::server {

class FarmCore;
class UserShares;
struct JobEntry;
struct JobShape;

/// Thread-safe. The other parts must outlive it.
class JobSubmission {
 public:
  JobSubmission(FarmCore& core, UserShares& shares) : core_(core), shares_(shares) {}

  /// Answers with the job's id, the same for a request that is sent twice. The quotas of `by` hold:
  /// PermissionDenied and ResourceExhausted, as Quotas has them; the latter also where there is no room, on
  /// the disk or in memory. InvalidArgument for a spec that is unsound, FailedPrecondition where blobs are
  /// missing or jobs that go before failed, NotFound where such a job, or the one to be continued, is not
  /// there, Unavailable when the farm stops.
  void submit(const v1::SubmitJobRequest& request, Done<std::string> done, const Caller& by = {});

 private:
  /// A job that may be taken, as far as can be said without the lock.
  struct Candidate {
    std::shared_ptr<const JobShape> shape;
    std::vector<std::uint64_t> blob_sizes;
    std::optional<Donor> donor;
    absl::Status room;  // whether the disk has room for it
  };
  absl::StatusOr<Candidate> check(const v1::SubmitJobRequest& request, const Caller& by);
  /// Sizes of the job's blobs, in their order. FailedPrecondition where some are missing.
  absl::StatusOr<std::vector<std::uint64_t>> blob_sizes(const v1::JobSpec& spec) const;
  absl::Status check_webhook(const std::string& webhook) const;
  /// The job that the new one takes results from; none when there is none. What is wrong with
  /// `request.continued`.
  absl::StatusOr<std::optional<Donor>> find_donor(const v1::SubmitJobRequest& request, const JobShape& shape);

  // With the farm's lock held.

  absl::StatusOr<const JobEntry*> best_donor(const v1::SubmitJobRequest& request, const v1::JobSpec& spec);
  /// Whether the jobs that the new one comes after are there, and may still be done.
  absl::Status check_after(const v1::JobSpec& spec);
  /// Whether the units of one more job fit into memory.
  absl::Status check_capacity(const JobShape& shape) const;
  JobEntry& add_entry(const Candidate& candidate, const std::string& key);
  /// Tells the scheduler of a new job. Returns what is to be journaled of it; after an error the scheduler
  /// does not know the job.
  absl::StatusOr<std::vector<JournalEntry>> schedule(JobEntry& entry, const std::optional<Donor>& donor);

  FarmCore& core_;
  UserShares& shares_;
};

}  // namespace tessera::server
