#include "scheduler/policy/faults.h"

#include <algorithm>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "scheduler/identity.h"
#include "scheduler/policy/unit_failures.h"

namespace tessera::server {
namespace {

constexpr char kLostMessage[] = "the worker was lost with this unit in its hands";
// When so large a part of the farm goes silent at once, it is the network, or its power, and not the unit.
constexpr std::size_t kMassLoss = 4;

}  // namespace

void Faults::fail(FarmJob& job, LeaseId id, const FailureReport& report, Time now) {
  const Lease lease = state_.leases.get(id);
  const std::string host = state_.workers.at(lease.worker).info.host;
  book_.drop(id);
  UnitFailure failure{.host = host,
                      .message = report.message,
                      .lost = false,
                      .scene_fault = report.scene_fault,
                      .inputs_fault = report.inputs_fault,
                      .grant = grant_id(lease.epoch, lease.attempt)};
  if (lease.spot != 0) {
    // Somebody else is asked; a host that cannot render what is done is asked no more of this one.
  } else if (!lease.audit && !report.scene_fault && lease.units.count > 1) {
    cut_run(job, lease.units, failure, report.log);
  } else if (lease.audit) {
    // The unit is done, and no worse for it; nobody needs to try again.
    job.audits.erase(lease.units.first);
    if (report.scene_fault) record_failure(job, lease.units.first, failure, report.log);
  } else {
    add_failure(job, lease.units.first, std::move(failure), report.log, now);
  }
  if (report.scene_fault && job.open()) {
    job.scene_faults[host] = report.message;
    bar(job, host, now);
    judge_scene(job, report.message, now);
  }
}

bool Faults::is_mass_loss(std::size_t workers) const {
  return workers >= kMassLoss && 2 * workers >= state_.workers.size();
}

bool Faults::blame_loss(LeaseId id, const WorkerInfo& worker, Time now) {
  const Lease lease = state_.leases.get(id);
  book_.drop(id);
  FarmJob& job = *state_.jobs_by_number.at(lease.job);
  if (lease.audit || !job.open()) return false;
  const UnitFailure failure{.host = worker.host,
                            .message = kLostMessage,
                            .lost = true,
                            .grant = grant_id(lease.epoch, lease.attempt)};
  const bool alone = lease.units.count == 1;
  alone ? add_failure(job, lease.units.first, failure, {}, now) : cut_run(job, lease.units, failure, {});
  return alone;
}

void Faults::record_failure(const FarmJob& job, std::uint32_t unit, const UnitFailure& failure,
                            const std::vector<std::string>& log) {
  using Kind = FarmEvent::Kind;
  FarmEvent& event = state_.record(failure.lost           ? Kind::kUnitLost
                                   : failure.scene_fault  ? Kind::kSceneFault
                                   : failure.inputs_fault ? Kind::kInputsFailed
                                   : failure.disputed     ? Kind::kDisputed
                                                          : Kind::kUnitFailed,
                                   job.request.id);
  event.unit = unit;
  event.value = failure.grant;
  event.host = failure.host;
  event.text = failure.message;
  event.log = log;
}

void Faults::add_failure(FarmJob& job, std::uint32_t unit, UnitFailure failure,
                         const std::vector<std::string>& log, Time now) {
  record_failure(job, unit, failure, log);
  const std::string host = failure.host;
  const bool speaks_of_host = !failure.lost && !failure.scene_fault;
  job.failures[unit].push_back(std::move(failure));
  if (speaks_of_host) judge_host(job, unit, host, now);
  judge_unit(job, unit);
}

/// Which of its units was at fault is not known: they are tried in shorter runs, and in the end one by one.
void Faults::cut_run(FarmJob& job, const UnitRun& units, const UnitFailure& failure,
                     const std::vector<std::string>& log) {
  FarmEvent& event =
      state_.record(failure.lost ? FarmEvent::Kind::kRunLost : FarmEvent::Kind::kRunFailed, job.request.id);
  event.unit = units.first;
  event.value = units.count;
  event.host = failure.host;
  event.text = failure.message;
  event.log = log;
  shorten_runs(job, units);
}

void Faults::shorten_runs(FarmJob& job, const UnitRun& units) {
  for (const std::uint32_t unit : units) {
    if (job.units.state(unit) != UnitState::kDone)
      job.shorter_runs[unit] = std::max(1u, units.count / kRunPieces);
  }
}

void Faults::judge_unit(FarmJob& job, std::uint32_t unit) {
  if (job.units.state(unit) == UnitState::kDone || job.units.state(unit) == UnitState::kSetAside) return;
  const std::vector<UnitFailure>& failures = job.failures[unit];
  if (losses_in(failures) >= kLossesToIsolate) {
    job.dangerous.insert(unit);
    state_.endangered.insert(job.number);
  }
  if (!failed_too_often(failures) || eligibility_.awaits_another(job, failures)) return;
  for (const LeaseId lease : state_.leases.of_unit(job.number, unit)) book_.drop(lease);
  job.units.set_aside(unit);
  forgive(job, unit);
  // Where nothing works, the rest need not be tried.
  if (job.open() && job.units.done() == 0 && job.units.set_aside() >= kMaxFailures) {
    course_.end(job, v1::FAILED, what_is_missing(job));
  }
}

/// The word of one identity that the scene is at fault ends no job as long as another one can be asked, or
/// has rendered units of it. Where two say so, they must be more than those who have rendered.
void Faults::judge_scene(FarmJob& job, const std::string& message, Time now) {
  const bool by_host = trust_.is_of_one_identity();
  const auto voter = [&](const std::string& host) { return by_host ? host : identity_of(host); };
  std::set<std::string> accusers, renderers;
  for (const auto& [host, its_message] : job.scene_faults) accusers.insert(voter(host));
  for (const HostNumber host : job.hosts_with_results) {
    if (host < state_.hosts_by_number.size() && !accusers.contains(voter(state_.hosts_by_number[host])))
      renderers.insert(voter(state_.hosts_by_number[host]));
  }
  const bool others = std::any_of(state_.workers.begin(), state_.workers.end(), [&](const auto& entry) {
    return !accusers.contains(voter(entry.second.info.host)) &&
           eligibility_.may_work_on(entry.second, job, now);
  });
  const bool agreed = accusers.size() > std::max<std::size_t>(1, renderers.size());
  if (agreed || (renderers.empty() && !others)) course_.end(job, v1::FAILED, message);
}

/// A host is at fault where several units fail that fail nowhere else; a unit that fails elsewhere too is at
/// fault itself, and is taken off every host's record.
void Faults::judge_host(FarmJob& job, std::uint32_t unit, const std::string& host, Time now) {
  if (hosts_of(job.failures[unit]).size() > 1) {
    for (auto& [name, record] : job.hosts) record.units_failed_only_here.erase(unit);
    return;
  }
  HostRecord& record = job.hosts[host];
  record.units_failed_only_here.insert(unit);
  if (record.units_failed_only_here.size() < kMaxFailures) return;
  const bool others = std::any_of(state_.workers.begin(), state_.workers.end(), [&](const auto& entry) {
    return entry.second.info.host != host && eligibility_.may_work_on(entry.second, job, now);
  });
  if (!others) return;  // the last resort is better than none
  const Time barred = bar(job, host, now);
  state_.note(job,
              absl::StrCat("host ", short_name(host), " was taken out for ", barred.count() / 1000,
                           " s: ", kMaxFailures, " units failed there and nowhere else, the last one with: ",
                           job.failures[unit].back().message));
}

/// Takes a host out of a job for a while, longer each time, and gives what it holds of it back. For how long.
Time Faults::bar(FarmJob& job, const std::string& host, Time now) {
  HostRecord& record = job.hosts[host];
  const Time bar = std::min(kLongestBar, kFirstBar * (std::int64_t{1} << std::min(record.bars, 10u)));
  ++record.bars;
  record.barred_until = now + bar;
  record.units_failed_only_here.clear();
  for (const auto& [id, worker] : state_.workers) {
    if (worker.info.host != host) continue;
    for (const LeaseId lease : state_.leases.of_worker(id)) {
      if (state_.leases.get(lease).job == job.number) book_.drop(lease);
    }
  }
  return bar;
}

void Faults::absolve(FarmJob& job, const v1::LeaseToken& token, const std::string& host) {
  const std::uint32_t unit = token.unit_index();
  const auto found = job.failures.find(unit);
  if (found == job.failures.end()) return;
  const std::int64_t grant = grant_id(token.epoch(), token.attempt());
  const auto removed = std::erase_if(found->second, [&](const UnitFailure& failure) {
    return failure.lost && failure.host == host && failure.grant == grant;
  });
  if (removed == 0) return;
  FarmEvent& event = state_.record(FarmEvent::Kind::kUnitFound, job.request.id);
  event.unit = unit;
  event.value = grant;
  event.host = host;
  if (losses_in(found->second) < kLossesToIsolate) forgive(job, unit);
  if (job.units.state(unit) == UnitState::kSetAside && !failed_too_often(found->second))
    job.units.put_back(unit);
  if (found->second.empty()) job.failures.erase(found);
}

void Faults::forgive(FarmJob& job, std::uint32_t unit) {
  job.dangerous.erase(unit);
  if (job.dangerous.empty()) state_.endangered.erase(job.number);
}

void Faults::reopen(FarmJob& job) {
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
  job.suspected.clear();
  job.questioned.clear();
  state_.endangered.erase(job.number);
  job.hosts.clear();
  job.scene_faults.clear();
  course_.take_turns(job);
}

void Faults::set_disputed_aside(FarmJob& job, std::uint32_t unit, const std::vector<std::string>& hosts,
                                const std::string& message) {
  for (const std::string& host : hosts) {
    const UnitFailure failure{.host = host, .message = message, .disputed = true};
    record_failure(job, unit, failure, {});
    job.failures[unit].push_back(failure);
  }
  job.units.set_aside(unit);
}

bool Faults::has_disputes(const FarmJob& job) const {
  return std::any_of(job.failures.begin(), job.failures.end(), [&](const auto& entry) {
    return job.units.state(entry.first) == UnitState::kSetAside && is_disputed(entry.second);
  });
}

std::set<std::uint32_t> Faults::doubted(const FarmJob& job) const {
  std::set<std::uint32_t> units;
  bool picture = false;  // whose units all read the same
  for (const auto& [unit, failures] : job.failures) {
    const bool unread = std::any_of(failures.begin(), failures.end(),
                                    [](const UnitFailure& failure) { return failure.inputs_fault; });
    if (!unread || job.units.state(unit) == UnitState::kDone) continue;
    const bool of_picture = job.request.plan->is_of_picture(unit);
    if (of_picture && picture) continue;
    picture = picture || of_picture;
    for (const std::uint32_t source : job.request.plan->phases().sources(unit)) {
      if (job.units.state(source) == UnitState::kDone && !job.confirmed.contains(source))
        units.insert(source);
    }
  }
  return units;
}

std::string Faults::what_is_missing(const FarmJob& job) const {
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

void Faults::restore(FarmJob& job, const FarmEvent& event) {
  using Kind = FarmEvent::Kind;
  switch (event.kind) {
    case Kind::kSceneFault:
      job.scene_faults[event.host] = event.text;
      [[fallthrough]];
    case Kind::kUnitFailed:
    case Kind::kUnitLost:
    case Kind::kInputsFailed:
    case Kind::kDisputed:
      if (job.units.state(event.unit) == UnitState::kDone) break;  // in the end it was rendered
      job.failures[event.unit].push_back({.host = event.host,
                                          .message = event.text,
                                          .lost = event.kind == Kind::kUnitLost,
                                          .scene_fault = event.kind == Kind::kSceneFault,
                                          .inputs_fault = event.kind == Kind::kInputsFailed,
                                          .disputed = event.kind == Kind::kDisputed,
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
    default:
      break;
  }
}

}  // namespace tessera::server
