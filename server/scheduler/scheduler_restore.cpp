// Restoring the scheduler from the journal.
#include <algorithm>

#include "absl/strings/str_cat.h"
#include "scheduler/scheduler.h"

namespace tessera::server {

absl::Status Scheduler::restore_done(std::string_view id, const AcceptedResult& result) {
  const absl::StatusOr<FarmJob*> job = find_job(id);
  if (!job.ok()) return job.status();
  UnitLedger& units = (*job)->units;
  for (const std::uint32_t unit : result.units) {
    if (unit < units.count() && units.state(unit) != UnitState::kDone) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("job ", std::string(id), " has no unit ", unit, " left to be done"));
  }
  units.finish(result);
  (*job)->hosts_with_results.insert(result.host);
  (*job)->results = std::max((*job)->results, result.sequence);
  (*job)->state = v1::RUNNING;
  return absl::OkStatus();
}

absl::Status Scheduler::restore_revoked(std::string_view id, std::uint32_t sequence) {
  const absl::StatusOr<FarmJob*> job = find_job(id);
  if (!job.ok()) return job.status();
  (*job)->results = std::max((*job)->results, sequence);
  ++(*job)->revision;
  return absl::OkStatus();
}

absl::Status Scheduler::restore(const FarmEvent& event) {
  using Kind = FarmEvent::Kind;
  if (event.kind == Kind::kDistrusted) {
    state_.distrusted[event.host] = event.text;
    return absl::OkStatus();
  }
  if (event.kind == Kind::kTrusted) {
    state_.distrusted.erase(event.host);
    return absl::OkStatus();
  }
  if (event.kind == Kind::kClassConfirmed) {
    state_.class_tally.confirm(event.text, event.host);
    return absl::OkStatus();
  }
  const absl::StatusOr<FarmJob*> found = find_job(event.job);
  if (!found.ok()) return found.status();
  FarmJob& job = **found;
  if (event.unit >= job.units.count()) {
    return absl::InvalidArgumentError(absl::StrCat("job ", event.job, " has no unit ", event.unit));
  }
  switch (event.kind) {
    case Kind::kSceneFault:
    case Kind::kUnitFailed:
    case Kind::kUnitLost:
    case Kind::kInputsFailed:
    case Kind::kDisputed:
    case Kind::kRunFailed:
    case Kind::kRunLost:
    case Kind::kUnitFound:
      faults_.restore(job, event);
      break;
    case Kind::kReopened:
      faults_.reopen(job);
      break;
    case Kind::kPaused:
      job.paused = event.value != 0;
      break;
    case Kind::kPriority:
      job.request.priority = static_cast<std::int32_t>(event.value);
      break;
    case Kind::kNote:
      if (job.notes.size() < FarmState::kMaxListed) job.notes.push_back(event.text);
      break;
    case Kind::kAudit:
      audits_.restore(job, event);
      break;
    case Kind::kAdopted:
      job.adopted = static_cast<std::uint32_t>(event.value);
      job.adopted_from = event.text;
      break;
    case Kind::kUnconfirmed:
      job.units_unconfirmed = static_cast<std::uint32_t>(event.value);
      break;
    case Kind::kClassNoted:
      job.classes.note(event.host, static_cast<std::uint32_t>(event.value), event.text);
      break;
    default:
      break;  // kBound, kEnded and kRevoked are part of the job's own record
  }
  return absl::OkStatus();
}

absl::Status Scheduler::restored(std::string_view id) {
  const absl::StatusOr<FarmJob*> found = find_job(id);
  if (!found.ok()) return found.status();
  FarmJob& job = **found;
  steps_.open(job);
  steps_.revoke_orphans(job);
  // Failures of units whose turn comes again were of what they had read.
  absl::erase_if(job.failures, [&](const auto& entry) { return entry.first >= job.units.open_end(); });
  course_.take_turns(job);
  std::vector<std::uint32_t> failed;
  for (const auto& [unit, failures] : job.failures) failed.push_back(unit);
  std::sort(failed.begin(), failed.end());
  for (const std::uint32_t unit : failed) {
    if (!job.open()) break;
    faults_.judge_unit(job, unit);
  }
  audits_.restored(job);
  checks_.restored(job);
  settle(job, Time{0});
  return absl::OkStatus();
}

}  // namespace tessera::server
