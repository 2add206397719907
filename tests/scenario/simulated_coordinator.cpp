#include "scenario/simulated_coordinator.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "absl/strings/str_cat.h"
#include "service/job/adoption.h"
#include "service/job/journal_events.h"

namespace tessera::server {

std::string digest_of(ResultFingerprint result) {
  char text[65];
  std::snprintf(text, sizeof(text), "%016llx%048d", static_cast<unsigned long long>(result), 0);
  return text;
}

CoveredUnits covered_by(const v1::LeaseToken& token) {
  return {.first = token.unit_index(), .ranges = std::max(token.ranges(), 1u)};
}

SimulatedCoordinator::SimulatedCoordinator(Journal& journal, const Jobs& jobs, SchedulerOptions options)
    : journal_(journal), scheduler_([&] {
        options.epoch = journal.epoch();
        return options;
      }()) {
  recovery_ = restore_farm(scheduler_, journal);
  recovery_.Update(journal.recover([&](const JobRecord& record) { return recover(record, jobs); }));
  push({}, nullptr);
}

absl::Status SimulatedCoordinator::recover(const JobRecord& record, const Jobs& jobs) {
  const std::string& id = record.added.id;
  const auto state = static_cast<v1::JobState>(record.ended.state);
  if (state != v1::JOB_STATE_UNSPECIFIED && state != v1::INCOMPLETE) {
    past_[id] = state;
    return absl::OkStatus();
  }
  return restore_job(scheduler_, jobs.at(id), record);
}

v1::JobState SimulatedCoordinator::past(const std::string& job) const {
  const auto found = past_.find(job);
  return found == past_.end() ? v1::JOB_STATE_UNSPECIFIED : found->second;
}

void SimulatedCoordinator::push(std::vector<JournalEntry> entries, Reply reply) {
  for (const FarmEvent& event : scheduler_.take_events()) append_to_journal(event, 1, entries);
  if (entries.empty() && reply == nullptr) return;
  waiting_.push_back({std::move(entries), std::move(reply)});
}

bool SimulatedCoordinator::binds(const std::string& job) const {
  for (const Waiting& item : waiting_) {
    for (const JournalEntry& entry : item.entries) {
      const auto* const bound = std::get_if<JobBound>(&entry);
      if (bound != nullptr && bound->id == job) return true;
    }
  }
  return false;
}

bool SimulatedCoordinator::revokes(const std::string& job, std::uint64_t sequence) const {
  for (const Waiting& item : waiting_) {
    for (const JournalEntry& entry : item.entries) {
      const auto* const event = std::get_if<SchedulerEvent>(&entry);
      if (event != nullptr && static_cast<FarmEvent::Kind>(event->kind) == FarmEvent::Kind::kRevoked &&
          event->job == job && event->value == static_cast<std::int64_t>(sequence)) {
        return true;
      }
    }
  }
  return false;
}

absl::Status SimulatedCoordinator::commit() {
  durable_ = std::exchange(waiting_, {});
  committed_.clear();
  for (const Waiting& item : durable_)
    committed_.insert(committed_.end(), item.entries.begin(), item.entries.end());
  return committed_.empty() ? absl::OkStatus() : journal_.commit(committed_);
}

void SimulatedCoordinator::answer() {
  for (const Waiting& item : std::exchange(durable_, {})) {
    if (item.reply) item.reply(absl::OkStatus());
  }
}

void SimulatedCoordinator::submit(const JobRequest& job, const JobRequest* donor, Reply reply) {
  // Sent a second time, the answer is the same.
  if (past(job.id) != v1::JOB_STATE_UNSPECIFIED || scheduler_.job(job.id).ok())
    return push({}, std::move(reply));
  if (absl::Status status = scheduler_.add_job(job); !status.ok()) return reply(status);
  std::vector<JournalEntry> entries;
  entries.push_back(JobAdded{.id = job.id,
                             .request_id = "request " + job.id,
                             .spec = job.id,
                             .generation = job.generation,
                             .submitted_unix_ms = 1,
                             .uploaded_bytes = 0});
  if (donor != nullptr) {
    const absl::StatusOr<JobRecord> record = journal_.read_job(donor->id);
    if (record.ok()) {
      Donor giver{*record, donor->plan};
      for (const JobRecord::Result& result : record->results) giver.blobs.insert(result.digest);
      if (const absl::Status status = adopt_results(scheduler_, job, giver, entries); !status.ok())
        return reply(status);
    }
  }
  push(std::move(entries), std::move(reply));
}

void SimulatedCoordinator::cancel(const std::string& job, Reply reply) {
  if (past(job) == v1::JOB_STATE_UNSPECIFIED) {
    if (const auto cancelled = scheduler_.cancel_job(job); !cancelled.ok()) return reply(cancelled.status());
  }
  push({}, std::move(reply));
}

void SimulatedCoordinator::retry(const std::string& job, Reply reply) {
  if (past(job) != v1::JOB_STATE_UNSPECIFIED) return reply(absl::FailedPreconditionError("the job is over"));
  if (absl::Status status = scheduler_.retry_job(job); !status.ok()) return reply(status);
  push({}, std::move(reply));
}

void SimulatedCoordinator::pause(const std::string& job, bool paused, Reply reply) {
  if (past(job) != v1::JOB_STATE_UNSPECIFIED) return reply(absl::FailedPreconditionError("the job is over"));
  if (absl::Status status = scheduler_.pause_job(job, paused); !status.ok()) return reply(status);
  push({}, std::move(reply));
}

void SimulatedCoordinator::lease(const LeaseRequest& request, Time now, LeaseReply reply) {
  absl::StatusOr<LeaseDecision> decision = scheduler_.lease(request, now);
  std::vector<std::string> isas;
  bool binding = false;
  if (decision.ok()) {
    for (const v1::Lease& lease : decision->leases) {
      binding |= binds(lease.token().job_id());
      isas.push_back(scheduler_.isa_for(request.worker, lease.token().job_id()));
    }
  }
  if (!binding && !scheduler_.has_events()) return reply(decision, isas);
  push({}, [decision = std::move(decision), isas, reply = std::move(reply)](const absl::Status&) {
    reply(decision, isas);
  });
}

absl::StatusOr<HeartbeatDecision> SimulatedCoordinator::heartbeat(const std::string& worker,
                                                                  const std::vector<v1::LeaseToken>& leases,
                                                                  Time now) {
  absl::StatusOr<HeartbeatDecision> decision = scheduler_.heartbeat(worker, leases, now);
  push({}, nullptr);
  return decision;
}

void SimulatedCoordinator::complete(const std::string& worker, const v1::LeaseToken& token,
                                    const DeliveredResult& result, Time now, Reply reply) {
  const std::string& job = token.job_id();
  if (const v1::JobState state = past(job); state != v1::JOB_STATE_UNSPECIFIED) {
    return reply(state == v1::DONE ? absl::OkStatus()
                                   : absl::FailedPreconditionError("the job was cancelled or failed"));
  }
  const absl::StatusOr<CompleteDecision> decision = scheduler_.complete(worker, token, result, now);
  if (!decision.ok()) {
    push({}, nullptr);
    return reply(decision.status());
  }
  if (decision->duplicate) return push({}, std::move(reply));
  push({UnitDone{.job = job,
                 .sequence = decision->sequence,
                 .units = covered_by(token),
                 .digest = digest_of(result.fingerprint),
                 .payload = absl::StrCat("payload ", job, " ", token.unit_index()),
                 .stats = "",
                 .host = scheduler_.host_of(worker)}},
       std::move(reply));
}

void SimulatedCoordinator::fail(const std::string& worker, const v1::LeaseToken& token, Time now,
                                Reply reply) {
  if (past(token.job_id()) != v1::JOB_STATE_UNSPECIFIED)
    return reply(absl::FailedPreconditionError("the job is over"));
  if (absl::Status status = scheduler_.fail(worker, token, {.message = "out of memory"}, now); !status.ok()) {
    return reply(status);
  }
  push({}, std::move(reply));
}

void SimulatedCoordinator::advance(Time now) {
  scheduler_.advance(now);
  push({}, nullptr);
}

}  // namespace tessera::server
