// How jobs that are over go, and the blobs that nobody needs any more.
#pragma once

#include <string>

#include "service/farm/done.h"
#include "service/farm/job_keeper.h"

namespace tessera::server {

class FarmCore;
class WorkerLeases;

/// Deletes jobs on request and when their time is over. With the farm's lock held, but for stop(). Core and
/// leases must outlive it.
class JobRetention {
 public:
  JobRetention(FarmCore& core, WorkerLeases& leases);

  /// Deletes a job, which is over, and its results.
  void forget(const std::string& id, DoneEmpty done);
  /// Deletes what is due.
  void tick();
  /// Notes how long it lived. Without the lock; once.
  void stop();

 private:
  /// Drops what is kept of the units of jobs that ended a while ago. An incomplete job may go on.
  void retire_jobs();
  /// Deletes jobs whose time is over.
  void prune();
  /// Blobs that workers uploaded a while ago, and that nothing names, are deleted.
  void drop_lease_uploads();

  FarmCore& core_;
  WorkerLeases& leases_;
  JobKeeper keeper_;
};

}  // namespace tessera::server
