// The results of units, and their failures.
#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "scheduler/spot_table.h"
#include "scheduler/unit_ledger.h"
#include "service/farm/done.h"
#include "service/farm/worker_origin.h"
#include "service/job/phase_blobs.h"
#include "store/journal.h"
#include "tessera/v1/work.pb.h"

namespace tessera::server {

class FarmCore;
class UserShares;
class WorkerLeases;
class WorkerRegistry;
struct CompleteDecision;
struct JobEntry;
struct JobShape;

/// All calls: NotFound as WorkerRegistry::check has it, or for a job that is not there; FailedPrecondition
/// for a lease that was never granted, or a job that is over; Unavailable when the farm stops. Thread-safe.
/// The other parts must outlive it.
class UnitResults {
 public:
  UnitResults(FarmCore& core, WorkerRegistry& workers, WorkerLeases& leases, UserShares& shares);

  /// Answers once the result is durable. InvalidArgument for what is no result of these units,
  /// ResourceExhausted when the disk is behind; else as Scheduler::complete has it.
  void complete(const v1::CompleteRequest& request, const WorkerOrigin& origin,
                Done<v1::CompleteResponse> done);
  void fail(const v1::FailRequest& request, const WorkerOrigin& origin, DoneEmpty done);

 private:
  /// A result with this fingerprint, and that of a spot of it.
  struct Fingerprints {
    std::string digest;
    Spot spot = {};
  };

  // Without the farm's lock.

  absl::StatusOr<Fingerprints> check_payload(const v1::CompleteRequest& request, const JobShape& shape,
                                             const UnitRun& units) const;
  /// Whether a unit of a phase may have made this blob.
  absl::Status check_made(const std::string& digest, const v1::WorkUnit& unit, const v1::JobSpec& spec);
  /// Bytes that have their digest came as they were made, and are none that a renderer makes: the worker has
  /// failed, and need not try again.
  void refuse_blob(const v1::CompleteRequest& request, const absl::Status& why);
  void accept(const v1::CompleteRequest& request, const Fingerprints& result,
              Done<v1::CompleteResponse> done);
  /// Which of these blobs the store does not have any more. Asks the disk.
  std::vector<PhaseBlobs::Made> lost(std::vector<PhaseBlobs::Made> blobs) const;

  // With the farm's lock held.

  /// NotFound, and FailedPrecondition for a job that is over.
  absl::StatusOr<JobEntry*> find_open_job(const v1::LeaseToken& token);
  /// The result counts, and cost that. Returns what is to be journaled of it.
  std::vector<JournalEntry> add(JobEntry& entry, const v1::CompleteRequest& request,
                                const std::string& digest, v1::UnitStats stats,
                                const CompleteDecision& decision);
  /// Answers what the worker asked for along with its result.
  v1::CompleteResponse respond(const v1::CompleteRequest& request);

  FarmCore& core_;
  WorkerRegistry& workers_;
  WorkerLeases& leases_;
  UserShares& shares_;
  const std::string spot_key_;
  std::mutex checking_;  // Lets one blob of a phase be in memory at a time.
};

}  // namespace tessera::server
