// The real scheduler and a journal, put together as the coordinator does it
// (server/service/farm/farm_core.cpp), but on one thread, one step at a time: so a test can let it die
// between any two of them.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "scheduler/scheduler.h"
#include "store/journal.h"

namespace tessera::server {

/// Hexadecimal, with the fingerprint in front.
std::string digest_of(ResultFingerprint result);

/// The units that the token of a lease names.
CoveredUnits covered_by(const v1::LeaseToken& token);

class SimulatedCoordinator {
 public:
  /// Sent once what it tells of is durable.
  using Reply = std::function<void(const absl::Status&)>;
  /// Meaning of a job id; jobs are journaled by name only.
  using Jobs = std::map<std::string, JobRequest>;

  /// Recovers. The journal must outlive the coordinator.
  SimulatedCoordinator(Journal& journal, const Jobs& jobs, SchedulerOptions options);
  const absl::Status& recovery() const { return recovery_; }

  /// `donor`: a job of equal content, whose results are taken over; null: none.
  void submit(const JobRequest& job, const JobRequest* donor, Reply reply);
  void cancel(const std::string& job, Reply reply);
  void retry(const std::string& job, Reply reply);
  void pause(const std::string& job, bool paused, Reply reply);
  /// The decision, and the kernels' ISA for each lease of it.
  using LeaseReply =
      std::function<void(const absl::StatusOr<LeaseDecision>&, const std::vector<std::string>& isas)>;
  void lease(const LeaseRequest& request, Time now, LeaseReply reply);
  absl::StatusOr<HeartbeatDecision> heartbeat(const std::string& worker,
                                              const std::vector<v1::LeaseToken>& leases, Time now);
  void complete(const std::string& worker, const v1::LeaseToken& token, const DeliveredResult& result,
                Time now, Reply reply);
  void fail(const std::string& worker, const v1::LeaseToken& token, Time now, Reply reply);
  void advance(Time now);

  /// Journals what waits, as one group. The replies are given by `answer`, if nobody dies in between.
  absl::Status commit();
  void answer();

  Scheduler& scheduler() { return scheduler_; }
  bool waits_for_commit() const { return !waiting_.empty(); }
  /// Whether the job is bound to a class, which is not durable yet.
  bool binds(const std::string& job) const;
  /// Whether a result does not count any more, which is not durable yet.
  bool revokes(const std::string& job, std::uint64_t sequence) const;
  /// Entries that the last commit made durable.
  const std::vector<JournalEntry>& committed() const { return committed_; }
  /// The state in which a job ended before this coordinator started; unspecified for all others.
  v1::JobState past(const std::string& job) const;

 private:
  absl::Status recover(const JobRecord& record, const Jobs& jobs);
  void push(std::vector<JournalEntry> entries, Reply reply);

  Journal& journal_;
  Scheduler scheduler_;
  absl::Status recovery_;
  std::map<std::string, v1::JobState> past_;
  struct Waiting {
    std::vector<JournalEntry> entries;
    Reply reply;
  };
  std::vector<Waiting> waiting_, durable_;
  std::vector<JournalEntry> committed_;
};

}  // namespace tessera::server
