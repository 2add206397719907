// Consequences where units are not rendered: who is at fault, the data or the host.
#include <algorithm>
#include <set>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/str_cat.h"
#include "scheduler/identity.h"
#include "scheduler/scheduler.h"

namespace tessera::server {
namespace {

constexpr char kLostMessage[] = "the worker was lost with this unit in its hands";
// When so large a part of the farm goes silent at once, it is the network, or its power, and not the unit.
constexpr std::size_t kMassLoss = 4;

std::set<std::string> hosts_of(const std::vector<UnitFailure>& failures) {
  std::set<std::string> hosts;
  for (const UnitFailure& failure : failures) hosts.insert(failure.host);
  return hosts;
}

std::size_t losses_in(const std::vector<UnitFailure>& failures) {
  return static_cast<std::size_t>(std::count_if(failures.begin(), failures.end(),
                                                [](const UnitFailure& failure) { return failure.lost; }));
}

/// A worker that says what went wrong is believed; one that died may have been killed by something else, so
/// either different hosts must have seen it, or the same few a number of times.
bool failed_too_often(const std::vector<UnitFailure>& failures) {
  return failures.size() - losses_in(failures) >= Scheduler::kMaxFailures ||
         hosts_of(failures).size() >= Scheduler::kMaxFailures || failures.size() >= Scheduler::kMaxLosses;
}

}  // namespace

absl::Status Scheduler::fail(std::string_view worker_id, const v1::LeaseToken& token,
                             const std::string& message, bool scene_fault, Time now) {
  const absl::StatusOr<Worker*> worker = find_worker(worker_id, now);
  if (!worker.ok()) return worker.status();
  const absl::StatusOr<Job*> open = find_open_job(token);
  if (!open.ok()) return open.status();
  Job& job = **open;
  const std::optional<LeaseId> lease = find_lease(job, token, worker_id);
  if (!lease) return absl::OkStatus();  // given up before: somebody else is at it
  const std::string& host = (*worker)->info.host;
  const bool audit = leases_.get(*lease).audit;
  const UnitRun units = leases_.get(*lease).units;
  drop_lease(*lease);
  UnitFailure failure{.host = host,
                      .message = message,
                      .lost = false,
                      .scene_fault = scene_fault,
                      .grant = grant_id(token.epoch(), token.attempt())};
  if (!audit && !scene_fault && units.count > 1) {
    cut_run(job, units, failure);
  } else if (audit) {
    // The unit is done, and no worse for it; nobody needs to try again.
    job.audits.erase(token.unit_index());
    if (scene_fault) record_failure(job, token.unit_index(), failure);
  } else {
    add_failure(job, token.unit_index(), std::move(failure), now);
  }
  if (scene_fault && job.open()) {
    job.scene_faults[host] = message;
    bar(job, host, now);
    judge_scene(job, message, now);
  }
  settle(job);
  return absl::OkStatus();
}

void Scheduler::record_failure(const Job& job, std::uint32_t unit, const UnitFailure& failure) {
  using Kind = FarmEvent::Kind;
  FarmEvent& event = record(failure.lost          ? Kind::kUnitLost
                            : failure.scene_fault ? Kind::kSceneFault
                                                  : Kind::kUnitFailed,
                            job.request.id);
  event.unit = unit;
  event.value = failure.grant;
  event.host = failure.host;
  event.text = failure.message;
}

void Scheduler::add_failure(Job& job, std::uint32_t unit, UnitFailure failure, Time now) {
  record_failure(job, unit, failure);
  const std::string host = failure.host;
  const bool speaks_of_host = !failure.lost && !failure.scene_fault;
  job.failures[unit].push_back(std::move(failure));
  if (speaks_of_host) judge_host(job, unit, host, now);
  judge_unit(job, unit);
}

/// Which of its units was at fault is not known: they are tried in shorter runs, and in the end one by one.
void Scheduler::cut_run(Job& job, const UnitRun& units, const UnitFailure& failure) {
  FarmEvent& event =
      record(failure.lost ? FarmEvent::Kind::kRunLost : FarmEvent::Kind::kRunFailed, job.request.id);
  event.unit = units.first;
  event.value = units.count;
  event.host = failure.host;
  event.text = failure.message;
  shorten_runs(job, units);
}

void Scheduler::shorten_runs(Job& job, const UnitRun& units) {
  for (const std::uint32_t unit : units) {
    if (job.units.state(unit) != UnitState::kDone)
      job.shorter_runs[unit] = std::max(1u, units.count / kRunPieces);
  }
}

/// Sets a unit aside that failed too often, and isolates one that may be what killed its workers.
void Scheduler::judge_unit(Job& job, std::uint32_t unit) {
  if (job.units.state(unit) == UnitState::kDone || job.units.state(unit) == UnitState::kSetAside) return;
  const std::vector<UnitFailure>& failures = job.failures[unit];
  if (losses_in(failures) >= kLossesToIsolate) {
    job.dangerous.insert(unit);
    endangered_.insert(job.number);
  }
  if (!failed_too_often(failures) || awaits_another(job, failures)) return;
  for (const LeaseId lease : leases_.of_unit(job.number, unit)) drop_lease(lease);
  job.units.set_aside(unit);
  forgive(job, unit);
  // Where nothing works, the rest need not be tried.
  if (job.open() && job.units.done() == 0 && job.units.set_aside() >= kMaxFailures) {
    end_job(job, v1::FAILED, what_is_missing(job));
  }
}

/// Whether the unit failed too often, but on one identity only, and another one could take it: one alone sets
/// nothing aside.
bool Scheduler::awaits_another(const Job& job, const std::vector<UnitFailure>& failures) const {
  if (!failed_too_often(failures)) return false;
  const std::string identity = identity_of(failures.front().host);
  const bool alone = std::all_of(failures.begin(), failures.end(), [&](const UnitFailure& failure) {
    return identity_of(failure.host) == identity;
  });
  return alone && std::any_of(workers_.begin(), workers_.end(), [&](const auto& entry) {
           const Worker& worker = entry.second;
           return identity_of(worker.info.host) != identity && may_work_on(worker, job, worker.last_seen);
         });
}

/// The word of one identity that the scene is at fault ends no job as long as another one can be asked, or
/// has rendered units of it. Where two say so, they must be more than those who have rendered.
void Scheduler::judge_scene(Job& job, const std::string& message, Time now) {
  const bool by_host = is_of_one_identity();
  const auto voter = [&](const std::string& host) { return by_host ? host : identity_of(host); };
  std::set<std::string> accusers, renderers;
  for (const auto& [host, its_message] : job.scene_faults) accusers.insert(voter(host));
  for (const HostNumber host : job.renderers) {
    if (host < hosts_.size() && !accusers.contains(voter(hosts_[host])))
      renderers.insert(voter(hosts_[host]));
  }
  const bool others = std::any_of(workers_.begin(), workers_.end(), [&](const auto& entry) {
    return !accusers.contains(voter(entry.second.info.host)) && may_work_on(entry.second, job, now);
  });
  const bool agreed = accusers.size() > std::max<std::size_t>(1, renderers.size());
  if (agreed || (renderers.empty() && !others)) end_job(job, v1::FAILED, message);
}

/// A host is at fault where several units fail that fail nowhere else; a unit that fails elsewhere too is at
/// fault itself, and is taken off every host's record.
void Scheduler::judge_host(Job& job, std::uint32_t unit, const std::string& host, Time now) {
  if (hosts_of(job.failures[unit]).size() > 1) {
    for (auto& [name, record] : job.hosts) record.failed_units.erase(unit);
    return;
  }
  HostRecord& record = job.hosts[host];
  record.failed_units.insert(unit);
  if (record.failed_units.size() < kMaxFailures) return;
  const bool others = std::any_of(workers_.begin(), workers_.end(), [&](const auto& entry) {
    return entry.second.info.host != host && may_work_on(entry.second, job, now);
  });
  if (!others) return;  // the last resort is better than none
  const Time barred = bar(job, host, now);
  note(job, absl::StrCat("host ", short_name(host), " was taken out for ", barred.count() / 1000,
                         " s: ", kMaxFailures, " units failed there and nowhere else, the last one with: ",
                         job.failures[unit].back().message));
}

/// Takes a host out of a job for a while, longer each time, and gives what it holds of it back. For how long.
Time Scheduler::bar(Job& job, const std::string& host, Time now) {
  HostRecord& record = job.hosts[host];
  const Time bar = std::min(kLongestBar, kFirstBar * (std::int64_t{1} << std::min(record.bars, 10u)));
  ++record.bars;
  record.barred_until = now + bar;
  record.failed_units.clear();
  for (const auto& [id, worker] : workers_) {
    if (worker.info.host != host) continue;
    for (const LeaseId lease : leases_.of_worker(id)) {
      if (leases_.get(lease).job == job.number) drop_lease(lease);
    }
  }
  return bar;
}

/// Blames every unit that a lost worker held: it may have died of any.
void Scheduler::blame_loss(const std::vector<WorkerInfo>& lost, Time now) {
  if (lost.size() >= kMassLoss && 2 * lost.size() >= workers_.size()) return;
  for (const WorkerInfo& worker : lost) {
    for (const LeaseId id : leases_.of_worker(worker.id)) {
      if (!leases_.contains(id)) continue;  // its job ended over another of these units
      const Lease lease = leases_.get(id);
      drop_lease(id);
      Job& job = *jobs_.at(lease.job);
      if (lease.audit || !job.open()) continue;
      const UnitFailure failure{.host = worker.host,
                                .message = kLostMessage,
                                .lost = true,
                                .grant = grant_id(lease.epoch, lease.attempt)};
      if (lease.units.count > 1) {
        cut_run(job, lease.units, failure);
      } else {
        add_failure(job, lease.units.first, failure, now);
        settle(job);
      }
    }
  }
}

/// A worker that was thought dead has been heard of, with the unit still in its hands: the unit did not kill
/// it.
void Scheduler::absolve(Job& job, const v1::LeaseToken& token, const std::string& host) {
  const std::uint32_t unit = token.unit_index();
  const auto found = job.failures.find(unit);
  if (found == job.failures.end()) return;
  const std::int64_t grant = grant_id(token.epoch(), token.attempt());
  const auto removed = std::erase_if(found->second, [&](const UnitFailure& failure) {
    return failure.lost && failure.host == host && failure.grant == grant;
  });
  if (removed == 0) return;
  FarmEvent& event = record(FarmEvent::Kind::kUnitFound, job.request.id);
  event.unit = unit;
  event.value = grant;
  event.host = host;
  if (losses_in(found->second) < kLossesToIsolate) forgive(job, unit);
  if (job.units.state(unit) == UnitState::kSetAside && !failed_too_often(found->second))
    job.units.put_back(unit);
  if (found->second.empty()) job.failures.erase(found);
}

/// The unit is not dangerous, or not any more.
void Scheduler::forgive(Job& job, std::uint32_t unit) {
  job.dangerous.erase(unit);
  if (job.dangerous.empty()) endangered_.erase(job.number);
}

// ---------------------------------------------------------------- trying again

absl::Status Scheduler::retry_job(std::string_view id) {
  const absl::StatusOr<Job*> found = find_job(id);
  if (!found.ok()) return found.status();
  Job& job = **found;
  if (job.state == v1::DONE) return absl::OkStatus();
  if (!job.open() && job.state != v1::INCOMPLETE) {
    return absl::FailedPreconditionError(
        absl::StrCat("job ", job.request.id, " is over and not incomplete; submit it again"));
  }
  record(FarmEvent::Kind::kReopened, job.request.id);
  reopen(job);
  return absl::OkStatus();
}

void Scheduler::reopen(Job& job) {
  if (!job.open()) {
    job.state = v1::RUNNING;
    job.error.clear();
  }
  for (const auto& [unit, failures] : job.failures) {
    if (job.units.state(unit) == UnitState::kSetAside) job.units.put_back(unit);
  }
  job.failures.clear();
  job.shorter_runs.clear();
  job.dangerous.clear();
  endangered_.erase(job.number);
  job.hosts.clear();
  job.scene_faults.clear();
  take_turns(job);
}

std::string Scheduler::what_is_missing(const Job& job) const {
  std::uint32_t unit = job.units.count();
  for (const auto& [failed, failures] : job.failures) {
    if (job.units.state(failed) == UnitState::kSetAside) unit = std::min(unit, failed);
  }
  const auto found = job.failures.find(unit);
  if (found == job.failures.end()) return "";
  const UnitFailure& last = found->second.back();
  return absl::StrCat(job.units.set_aside(), " of ", job.units.count(), " units were set aside; unit ", unit,
                      " failed ", found->second.size(), " times, the last time on ", short_name(last.host),
                      ": ", last.message);
}

// ---------------------------------------------------------------- recovery

absl::Status Scheduler::restore(const FarmEvent& event) {
  using Kind = FarmEvent::Kind;
  if (event.kind == Kind::kDistrusted) {
    distrusted_[event.host] = event.text;
    return absl::OkStatus();
  }
  if (event.kind == Kind::kTrusted) {
    distrusted_.erase(event.host);
    return absl::OkStatus();
  }
  const absl::StatusOr<Job*> found = find_job(event.job);
  if (!found.ok()) return found.status();
  Job& job = **found;
  if (event.unit >= job.units.count()) {
    return absl::InvalidArgumentError(absl::StrCat("job ", event.job, " has no unit ", event.unit));
  }
  switch (event.kind) {
    case Kind::kSceneFault:
      job.scene_faults[event.host] = event.text;
      [[fallthrough]];
    case Kind::kUnitFailed:
    case Kind::kUnitLost:
      if (job.units.state(event.unit) == UnitState::kDone) break;  // in the end it was rendered
      job.failures[event.unit].push_back({.host = event.host,
                                          .message = event.text,
                                          .lost = event.kind == Kind::kUnitLost,
                                          .scene_fault = event.kind == Kind::kSceneFault,
                                          .grant = event.value});
      break;
    case Kind::kRunFailed:
    case Kind::kRunLost:
      if (const auto run = job.request.plan->run(event.unit, static_cast<std::uint32_t>(event.value))) {
        shorten_runs(job, *run);
      }
      break;
    case Kind::kUnitFound:
      if (const auto failures = job.failures.find(event.unit); failures != job.failures.end()) {
        std::erase_if(failures->second, [&](const UnitFailure& failure) {
          return failure.lost && failure.host == event.host && failure.grant == event.value;
        });
        if (failures->second.empty()) job.failures.erase(failures);
      }
      break;
    case Kind::kReopened:
      reopen(job);
      break;
    case Kind::kPaused:
      job.paused = event.value != 0;
      break;
    case Kind::kPriority:
      job.request.priority = static_cast<std::int32_t>(event.value);
      break;
    case Kind::kNote:
      if (job.notes.size() < kMaxListed) job.notes.push_back(event.text);
      break;
    case Kind::kAudit:
      restore_audit(job, event);
      break;
    case Kind::kAdopted:
      job.adopted = static_cast<std::uint32_t>(event.value);
      job.adopted_from = event.text;
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
  const absl::StatusOr<Job*> found = find_job(id);
  if (!found.ok()) return found.status();
  Job& job = **found;
  open_steps(job);
  revoke_orphans(job);
  // Failures of units whose turn comes again were of what they had read.
  absl::erase_if(job.failures, [&](const auto& entry) { return entry.first >= job.units.open_end(); });
  take_turns(job);
  std::vector<std::uint32_t> failed;
  for (const auto& [unit, failures] : job.failures) failed.push_back(unit);
  std::sort(failed.begin(), failed.end());
  for (const std::uint32_t unit : failed) {
    if (!job.open()) break;
    judge_unit(job, unit);
  }
  restore_audits(job);
  settle(job);
  return absl::OkStatus();
}

}  // namespace tessera::server
