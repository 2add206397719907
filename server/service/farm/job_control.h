// Calls of clients about jobs that are there.
#pragma once

#include <string>

#include "service/farm/caller.h"
#include "service/farm/done.h"
#include "tessera/v1/farm.pb.h"

namespace tessera::server {

class FarmCore;
class FarmViews;
class JobRetention;
class UserShares;

/// Each change is answered once it is durable: NotFound where there is no such job, Unavailable when the farm
/// stops. Thread-safe. The other parts must outlive it.
class JobControl {
 public:
  JobControl(FarmCore& core, const UserShares& shares, JobRetention& retention, FarmViews& views);

  void cancel(const std::string& id, Done<v1::JobStatus> done);
  /// FailedPrecondition when the job is not over.
  void delete_job(const std::string& id, DoneEmpty done);
  /// FailedPrecondition when the job is over and not incomplete. The quotas of `by` hold.
  void retry(const std::string& id, Done<v1::JobStatus> done, const Caller& by = {});
  /// FailedPrecondition when the job is over. The quotas of `by` hold.
  void adjust(const v1::AdjustJobRequest& request, Done<v1::JobStatus> done, const Caller& by = {});
  /// A client has received every result of a job that is over.
  void note_fetched(const std::string& id);

 private:
  /// Answers a call that changed a job, once it is durable. With the farm's lock held.
  void answer_with_status(const absl::Status& changed, const std::string& id, Done<v1::JobStatus> done);

  FarmCore& core_;
  const UserShares& shares_;
  JobRetention& retention_;
  FarmViews& views_;
};

}  // namespace tessera::server
