// The core that all parts of the farm lean on: one lock around the scheduler and the job table, and the
// journal behind them. What a call changed is journaled before the call is answered; the lock is never held
// across disk writes.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "scheduler/scheduler.h"
#include "service/farm/dispatcher.h"
#include "service/farm/done.h"
#include "service/farm/farm_news.h"
#include "service/farm/farm_options.h"
#include "service/job/job_table.h"
#include "store/blobs/blob_store.h"
#include "store/commit_queue.h"
#include "store/journal.h"

namespace tessera::server {

/// Thread-safe. Journal, blobs, clock, listener and observers must outlive it.
class FarmCore {
 public:
  /// A change of a job that becomes visible to clients when it is durable.
  struct Shown {
    std::string job;
    std::uint64_t results = 0;  // up to this sequence number; 0: as before
    bool end = false;
    std::uint32_t times_reopened = 0;  // an end counts only when the job was not opened again since
    bool bound_to_class = false;
  };
  struct Change {
    std::vector<JournalEntry> entries = {};
    std::vector<Shown> shown = {};
  };

  /// Holds the lock until start(). `on_failure` is called, once, when the journal can no longer be written.
  FarmCore(Journal& journal, BlobStore& blobs, const FarmOptions& options,
           std::function<void(absl::Status)> on_failure);

  // ---- the farm's life

  /// Takes the journal's jobs in. Before start().
  absl::Status recover();
  /// From now on `tick` is called, with the lock held, four times a second at least.
  void start(std::function<void()> tick);
  /// Answers all waiting calls with Unavailable, and all later ones. False where it was called before.
  bool stop();
  /// Commits all that is left, and answers who waits for that. The last call, after stop().
  void close() { commits_.reset(); }

  bool stopping() const { return stopping_; }
  /// Unavailable when the farm stops.
  absl::Status check_serving() const;

  // ---- means of its parts

  const FarmOptions& options() const { return options_; }
  Journal& journal() { return journal_; }
  BlobStore& blobs() { return blobs_; }
  base::Clock& clock() const { return clock_; }
  Time now() const;
  std::int64_t unix_now() const { return clock_.wall().count(); }  // in milliseconds
  Dispatcher& dispatcher() { return dispatcher_; }
  /// Tells the observers.
  void tell(const FarmNews& news) const;
  /// Bytes of changes that are not durable yet.
  std::uint64_t waiting_bytes() const { return commits_->waiting_bytes(); }

  // ---- the state. With the lock held.

  std::mutex& mutex() const { return mutex_; }
  Scheduler& scheduler() { return scheduler_; }
  JobTable& jobs() { return jobs_; }
  /// NotFound.
  absl::StatusOr<JobEntry*> find_job(const std::string& id);
  JobView view_of(const JobEntry& entry) const;
  /// The job's status for a list: without what takes long to find or to read.
  v1::JobStatus outline(const JobEntry& entry) const;

  /// Journals `change`, and behind it what the scheduler wants to have journaled, in the order of calls;
  /// `done` after that, and after all that was committed before.
  void commit(Change change, DoneEmpty done);
  /// Journals what the scheduler wants to have journaled; nobody waits for it.
  void commit();
  /// A result that was journaled cannot be read any more: its units are done again. Returns `damage` where
  /// they cannot be.
  absl::Status do_again(JobEntry& entry, std::uint64_t sequence, const absl::Status& damage);

 private:
  absl::Status recover(JobRecord record);
  /// Takes the scheduler's events into the change, and into the jobs that they are about.
  void add_events(Change& change);
  void push(Change change, DoneEmpty done);
  void note_event(const FarmEvent& event, std::vector<Shown>& shown);
  /// The host, or the identity, returned wrong results: perhaps to this job, too.
  void note_distrusted(const JobEntry& entry, const std::string& subject);
  /// The changes are durable. Without the lock.
  void show(const std::vector<Shown>& shown);
  /// The journal cannot be written any more.
  void fail(const absl::Status& why);

  Journal& journal_;
  BlobStore& blobs_;
  const FarmOptions options_;
  base::Clock& clock_;
  const std::function<void(absl::Status)> on_failure_;
  std::atomic<bool> stopping_ = false;
  std::atomic<bool> failed_ = false;

  mutable std::mutex mutex_;
  // Held until all is recovered: by half of the jobs a tick would judge which blobs nobody needs.
  std::unique_lock<std::mutex> starting_{mutex_};
  Scheduler scheduler_;
  JobTable jobs_;
  std::function<void()> tick_;

  // Goes after the queue: what that commits may still notify the dispatcher, whose thread has ended by then.
  Dispatcher dispatcher_;
  std::optional<CommitQueue> commits_;
};

/// Tells how long a call takes, its wait for the lock included.
class TimedCall {
 public:
  TimedCall(const FarmCore& core, news::Call call) : core_(core), call_(call) {}
  ~TimedCall() { core_.tell(news::CallServed{call_, std::chrono::steady_clock::now() - start_}); }
  TimedCall(const TimedCall&) = delete;
  TimedCall& operator=(const TimedCall&) = delete;

 private:
  const FarmCore& core_;
  const news::Call call_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace tessera::server
