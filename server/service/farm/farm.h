// The coordinator's logic behind its services: one lock around the scheduler and the job table, the journal
// behind them. What a call changed is journaled before the call is answered; the lock is never held across
// disk writes.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/statusor.h"
#include "scheduler/scheduler.h"
#include "service/farm/accounts.h"
#include "service/farm/caller.h"
#include "service/farm/dispatcher.h"
#include "service/farm/farm_clock.h"
#include "service/farm/job_keeper.h"
#include "service/farm/lease_seal.h"
#include "service/farm/lease_uploads.h"
#include "service/farm/quotas.h"
#include "service/farm/unclaimed_uploads.h"
#include "service/job/adoption.h"
#include "service/job/end_listener.h"
#include "service/job/job_table.h"
#include "service/metrics.h"
#include "store/blobs/blob_store.h"
#include "store/commit_queue.h"
#include "store/journal.h"
#include "tessera/v1/blob.pb.h"
#include "tessera/v1/farm.pb.h"
#include "tessera/v1/work.pb.h"

namespace tessera::server {

struct FarmOptions {
  std::chrono::milliseconds heartbeat_interval;
  std::chrono::milliseconds lease_timeout;
  std::chrono::milliseconds late_results;  // how long after a job's end its units are kept in memory
  Retention retention;
  std::uint64_t max_open_units = std::uint64_t{1} << 27;  // units of all jobs in memory together
  Quotas quotas = {};
  std::chrono::milliseconds longest_run{10'000};  // SchedulerOptions::longest_run
  JobOrder order = JobOrder::kFirstCome;
  bool share_results = false;             // jobs take over those of other users' jobs too
  std::shared_ptr<const LeaseSeal> seal;  // seal of this data directory
  std::filesystem::path lived_time = {};  // the file of LivedTime; empty: none
  // Defaults of jobs that do not say: JobSpec.bits and JobSpec.isa.
  v1::Bits bits = v1::BITS_SAME;
  std::string isa = {};
  std::chrono::milliseconds settle{0};  // SchedulerOptions::settle
  // The same of SchedulerOptions.
  double unconfirmed_share = 0.05;
  std::vector<std::string> classes = {};
  std::chrono::milliseconds class_patience{600'000};
  EndListener* listener = nullptr;      // outlives the farm; null: nobody is told
  FarmClock* clock = &machine_clock();  // outlives the farm
};

/// Some results of a job, and its status.
struct WatchBatch {
  v1::WatchJobResponse response;
  std::uint64_t last = 0;  // sequence number of the last result so far
  bool finished = false;   // the job is over and `last` was its last result
};

/// Safe to use from any number of threads. Every `done` is called exactly once, from any thread, and may be
/// called before the function returns.
class Farm {
 public:
  template <typename T>
  using Done = std::function<void(absl::StatusOr<T>)>;
  using DoneEmpty = std::function<void(absl::Status)>;

  /// Recovers the journal's jobs. `on_failure` is called, once, when the journal can no longer be written:
  /// nothing is acknowledged from then on. Journal and blobs must outlive the farm.
  static absl::StatusOr<std::unique_ptr<Farm>> open(Journal& journal, BlobStore& blobs,
                                                    const FarmOptions& options,
                                                    std::function<void(absl::Status)> on_failure);
  /// Answers what waits, and commits all that is left.
  ~Farm();

  /// Answers all waiting calls with Unavailable, and all later ones. Not to be called from a `done` or a
  /// `wake`.
  void stop();

  // ---- clients. The quotas of `by` hold: PermissionDenied and ResourceExhausted, as Quotas has them.

  void submit(const v1::SubmitJobRequest& request, Done<std::string> done, const Caller& by = {});
  absl::StatusOr<v1::GetJobResponse> get_job(const std::string& id);
  v1::ListJobsResponse list_jobs();
  /// Who submitted a job.
  absl::StatusOr<std::string> owner_of(const std::string& id);
  void cancel(const std::string& id, Done<v1::JobStatus> done);
  /// FailedPrecondition when the job is not over.
  void delete_job(const std::string& id, DoneEmpty done);
  void retry(const std::string& id, Done<v1::JobStatus> done, const Caller& by = {});
  void adjust(const v1::AdjustJobRequest& request, Done<v1::JobStatus> done, const Caller& by = {});
  v1::ListWorkersResponse list_workers();
  /// How often each worker is to be heard of, now.
  std::chrono::milliseconds heartbeat_interval() const;
  void trust_host(const std::string& host, DoneEmpty done);
  /// A client has received every result of a job that is over.
  void note_fetched(const std::string& id);

  // ---- who looks on (farm_views.cpp)

  /// The job's shape, which follows from its spec. NotFound.
  absl::StatusOr<std::shared_ptr<const JobShape>> shape_of(const std::string& id);
  /// The payload of one result, by its sequence number. DataLoss where it cannot be read any more.
  absl::StatusOr<std::string> result_of(const std::string& id, std::uint64_t sequence);
  /// Costs of the results `after + 1`, ..., `most` of them at most.
  absl::StatusOr<std::vector<v1::UnitStats>> costs_of(const std::string& id, std::uint64_t after,
                                                      std::uint32_t most);
  /// The blob that the job's last phase made. NotFound where there is none, or not yet, or not any more.
  absl::StatusOr<std::string> last_phase_of(const std::string& id);
  /// Pixels that workers, named by their ids, are rendering for the job: `most` leases at most.
  struct PixelsInWork {
    v1::PixelRect pixels;
    std::string worker;
  };
  std::vector<PixelsInWork> in_work(const std::string& id, std::size_t most);

  /// Returns what a watcher that has results up to `after` gets next; no results when there are none yet.
  absl::StatusOr<WatchBatch> next_results(const std::string& id, std::uint64_t after, bool status_only);
  /// Calls `wake`, from one thread for all, after each change of any job and every second or so; false from
  /// `wake` ends that.
  void subscribe(std::function<bool()> wake) { dispatcher_.subscribe(std::move(wake)); }
  bool stopping() const { return stopping_; }

  /// A client begins to upload a blob, or goes on with it: its bytes count against the client until a job
  /// names it.
  absl::Status begin_upload(const v1::BlobRef& blob, const Caller& by);
  /// A blob was uploaded, so the next job that refers to it is told what it cost.
  void note_upload(const std::string& digest, std::uint64_t bytes);

  // ---- workers

  /// Who calls: the name in the caller's certificate, the fingerprint of its key (identity.h), and its
  /// address. Empty where these are not known; whoever has no fingerprint is taken at their word.
  struct Origin {
    std::string certificate, peer, fingerprint;
    std::shared_ptr<const Accounts::Hold> account;  // holds what the worker takes, until it leaves
  };
  absl::StatusOr<v1::RegisterResponse> register_worker(const v1::RegisterRequest& request,
                                                       const Origin& origin = {});
  /// Workers that registered with a certificate of this name leave at once; others get what they had leased.
  /// How many that were.
  std::uint32_t expel(const std::string& certificate);
  /// Answers when there is work, after the wait asked for, or with nothing when `cancelled` turned true.
  void lease(v1::LeaseRequest request, const Origin& origin, std::function<bool()> cancelled,
             Done<v1::LeaseResponse> done);
  absl::StatusOr<v1::HeartbeatResponse> heartbeat(const v1::HeartbeatRequest& request,
                                                  const Origin& origin = {});
  void complete(const v1::CompleteRequest& request, const Origin& origin, Done<v1::CompleteResponse> done);
  void fail(const v1::FailRequest& request, const Origin& origin, DoneEmpty done);
  absl::Status deregister(const std::string& worker, const Origin& origin = {});
  /// A worker begins to upload a blob, or goes on with it, as BlobService.Upload has it. It counts against
  /// the worker's identity until a result names it.
  absl::Status begin_unit_upload(const v1::UploadRequest& first, const Origin& origin);

  const FarmMetrics& metrics() const { return metrics_; }
  const FarmClock& clock() const { return clock_; }

 private:
  Farm(Journal& journal, BlobStore& blobs, const FarmOptions& options,
       std::function<void(absl::Status)> on_failure);

  Time now() const;
  std::int64_t unix_now() const { return clock_.wall().count(); }  // in milliseconds
  absl::Status check_serving() const;

  // With mutex_ held.
  absl::Status recover(JobRecord record);
  absl::StatusOr<JobEntry*> find_job(const std::string& id);
  JobView view_of(const JobEntry& entry) const;
  v1::JobStatus describe(const JobEntry& entry) const;
  /// The same, for a list: without what takes long to find or to read.
  v1::JobStatus outline(const JobEntry& entry) const;
  /// Changes that a commit makes visible to clients.
  struct Shown {
    std::string job;
    std::uint64_t results = 0;  // up to this sequence number; 0: as before
    bool end = false;
    std::uint32_t times_reopened = 0;  // an end counts only when the job was not opened again since
    bool bound_to_class = false;
  };
  /// The changes are durable. Without mutex_.
  void show(const std::vector<Shown>& shown);
  /// Journals `entries`, and behind them what the scheduler wants to have journaled, in the order of calls;
  /// `done` after that. Answers at once where there is nothing, if `wait` is not set.
  void commit(std::vector<JournalEntry> entries, std::vector<Shown> shown, bool wait, DoneEmpty done);
  /// The host, or the identity, returned wrong results: perhaps to this job too.
  void note_distrusted(const JobEntry& entry, const std::string& subject);
  void note_event(const FarmEvent& event, std::vector<Shown>& shown);
  /// Answers a call that changed a job, once it is durable.
  void answer_with_status(const absl::Status& changed, const std::string& id, Done<v1::JobStatus> done);
  void prune();
  /// Blobs that workers uploaded a while ago, and that nothing names, are deleted. With mutex_ held.
  void drop_lease_uploads();
  /// The job, which is over, and its results are deleted.
  void forget(const std::string& id, DoneEmpty done);
  void retire_jobs();
  /// A result that was journaled cannot be read any more. With mutex_ held.
  absl::Status do_again(JobEntry& entry, std::uint64_t sequence, const absl::Status& damage);

  /// Sizes of the job's blobs, in their order. FailedPrecondition where some are missing.
  absl::StatusOr<std::vector<std::uint64_t>> blob_sizes(const v1::JobSpec& spec) const;
  /// Whether the jobs that the new one comes after are there, and may still be done. With mutex_ held.
  absl::Status check_after(const v1::JobSpec& spec);
  /// Whether the units of one more job fit into memory. With mutex_ held.
  absl::Status check_capacity(const JobShape& shape) const;
  /// Returns the user's share of the farm. With mutex_ held.
  UserShare share_of(const std::string& user) const;
  /// The share that the job's user has with one more such job, and with these blobs. With mutex_ held.
  UserShare share_with(const JobShape& shape, const std::vector<std::uint64_t>& sizes) const;
  /// Whether `by` may have the job opened again, which is over. With mutex_ held.
  absl::Status check_reopening(const JobEntry& entry, const Caller& by) const;
  /// The job that the new one takes results from; none when there is none. What is wrong with
  /// `request.continued`.
  absl::StatusOr<std::optional<Donor>> find_donor(const v1::SubmitJobRequest& request, const JobShape& shape);
  absl::StatusOr<const JobEntry*> best_donor(const v1::SubmitJobRequest& request, const v1::JobSpec& spec);
  /// A new job, of which the scheduler knows, and what is to be journaled of it. With mutex_ held.
  absl::StatusOr<std::vector<JournalEntry>> add_job(JobEntry& entry, const std::optional<Donor>& donor);
  /// NotFound for a worker that is not known, or was registered by the holder of another key. With mutex_
  /// held.
  absl::Status check_worker(const std::string& worker, const Origin& origin) const;
  /// FailedPrecondition for a lease that was never granted to the host of this worker. With mutex_ held.
  absl::Status check_granted(const std::string& worker, const v1::LeaseToken& token) const;
  /// Which of these blobs the store does not have any more. Asks the disk: to be called without mutex_.
  std::vector<PhaseBlobs::Made> lost(std::vector<PhaseBlobs::Made> blobs) const;
  /// Grants what is to be had now. With mutex_ held.
  absl::StatusOr<v1::LeaseResponse> grant(const std::string& worker, const v1::LeaseRequest& request);
  /// A heartbeat, whatever brought it. With mutex_ held.
  absl::StatusOr<v1::HeartbeatResponse> beat(const std::string& worker, const v1::HeartbeatRequest& request);
  /// Tries once; true when the call was answered.
  bool try_lease(const v1::LeaseRequest& request, bool last, const Done<v1::LeaseResponse>& done);
  /// A result with this fingerprint, and that of a spot of it.
  struct Fingerprints {
    std::string digest;
    Spot spot = {};
  };
  absl::StatusOr<Fingerprints> check_payload(const v1::CompleteRequest& request, const JobShape& shape,
                                             const UnitRun& units) const;
  /// Whether a unit of a phase may have made this blob. Without mutex_.
  absl::Status check_made(const std::string& digest, const v1::WorkUnit& unit, const v1::JobSpec& spec);
  /// The unit's blob is none that a renderer makes: the worker has failed. Without mutex_.
  void refuse_blob(const v1::CompleteRequest& request, const absl::Status& why);
  void accept_result(const v1::CompleteRequest& request, const Fingerprints& result,
                     Done<v1::CompleteResponse> done);
  void tick();

  Journal& journal_;
  BlobStore& blobs_;
  const FarmOptions options_;
  FarmClock& clock_;
  const std::function<void(absl::Status)> on_failure_;
  std::atomic<bool> stopping_ = false;
  std::atomic<bool> failed_ = false;

  const std::shared_ptr<const LeaseSeal> seal_;
  const std::string spot_key_ = seal_->derive_key("spots");

  std::mutex checking_;  // one blob of a phase is in memory at a time
  mutable std::mutex mutex_;
  Scheduler scheduler_;
  JobTable jobs_;
  UnclaimedUploads uploads_;
  LeaseUploads lease_uploads_;
  struct Registration {
    std::shared_ptr<const Accounts::Hold> account;
    std::uint64_t failures = 0, resident_bytes = 0;  // shown to people
  };
  absl::flat_hash_map<std::string, Registration> registrations_by_worker_;
  JobKeeper keeper_;

  FarmMetrics metrics_;
  // Goes first: what it commits may still notify the dispatcher, whose thread has ended by then.
  Dispatcher dispatcher_;
  CommitQueue commits_;
};

}  // namespace tessera::server
