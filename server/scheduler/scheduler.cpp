// Workers and results. Jobs are in scheduler_jobs.cpp, what a restart brings back in scheduler_restore.cpp;
// decisions are those of the policies.
#include "scheduler/scheduler.h"

#include <algorithm>
#include <map>

#include "absl/strings/str_cat.h"
#include "scheduler/identity.h"
#include "scheduler/policy/unit_failures.h"
#include "wire/arithmetic_class.h"
#include "wire/limits.h"

namespace tessera::server {
namespace {

absl::Status no_such_worker(std::string_view id) {
  return absl::NotFoundError(absl::StrCat("worker ", std::string(id), " is not known; register again"));
}

}  // namespace

// ---------------------------------------------------------------- workers

absl::Status Scheduler::register_worker(WorkerInfo info, Time now) {
  if (info.host.empty()) info.host = info.name;
  if (info.classes.empty()) info.classes = info.supported_isas;
  info.threads = std::clamp(info.threads, 1u, wire::kMaxLeasesPerWorker);
  const std::string id = info.id;
  const std::string identity = identity_of(info.host);
  const std::uint32_t threads = info.threads;
  // Until results show otherwise, it is as fast as the others.
  const WorkerPace pace{.worker = ++state_.workers_added, .log_time = state_.usual_pace.log_time};
  const bool added =
      state_.workers.emplace(id, FarmWorker{.info = std::move(info), .last_seen = now, .pace = pace}).second;
  if (!added) return absl::AlreadyExistsError(absl::StrCat("there is a worker ", id));
  state_.total_threads += threads;
  state_.workers_by_identity[identity].insert(id);
  FarmWorker& worker = state_.workers.at(id);
  worker.counted_threads = threads;
  if (!state_.class_tally.has(worker.info.classes)) state_.settled_at = now + state_.options.settle;
  classes_.count(worker);
  return absl::OkStatus();
}

absl::Status Scheduler::deregister_worker(std::string_view worker) {
  if (!state_.workers.contains(std::string(worker))) return no_such_worker(worker);
  drop_worker(worker);
  return absl::OkStatus();
}

absl::Status Scheduler::drain_worker(std::string_view worker) {
  const auto found = state_.workers.find(std::string(worker));
  if (found == state_.workers.end()) return no_such_worker(worker);
  found->second.draining = true;
  classes_.count(found->second);
  return absl::OkStatus();
}

std::vector<WorkerView> Scheduler::workers() const {
  std::vector<WorkerView> views;
  // Machines of one kind may work on the same jobs.
  std::map<std::pair<std::vector<std::string>, std::vector<std::string>>, std::vector<std::string>> closed;
  for (const auto& [id, worker] : state_.workers) {
    const auto [kind, is_new] = closed.try_emplace({worker.info.classes, worker.info.tags});
    if (is_new) kind->second = classes_.closed_jobs(worker);
    views.push_back({.info = worker.info,
                     .leases = static_cast<std::uint32_t>(state_.leases.count_of_worker(id)),
                     .units_done = worker.units_done,
                     .draining = worker.draining,
                     .last_seen = worker.last_seen,
                     .quarantine = trust_.why_distrusted(worker.info.host).value_or(""),
                     .slowness = worker.slowness,
                     .closed_jobs = kind->second});
  }
  std::sort(views.begin(), views.end(), [](const WorkerView& a, const WorkerView& b) {
    return std::tie(a.info.name, a.info.id) < std::tie(b.info.name, b.info.id);
  });
  return views;
}

std::vector<Assignment> Scheduler::assignments() const {
  std::vector<Assignment> assignments;
  for (const auto& [number, job] : state_.jobs_by_number) {
    for (const auto& [worker, leases] : job->holders)
      assignments.push_back({job->request.id, worker, leases});
  }
  return assignments;
}

void Scheduler::drop_worker(std::string_view id) {
  const std::string worker(id);
  for (const LeaseId lease : state_.leases.of_worker(worker)) book_.drop(lease);
  const auto found = state_.workers.find(worker);
  state_.total_threads -= found->second.counted_threads;
  const auto identity = state_.workers_by_identity.find(identity_of(found->second.info.host));
  identity->second.erase(worker);
  if (identity->second.empty()) state_.workers_by_identity.erase(identity);
  state_.freeing.erase(worker);
  if (found->second.is_tallied) state_.class_tally.remove(found->second.info, found->second.counted_threads);
  state_.workers.erase(found);
  state_.results_since_pace_comparison =
      state_.workers.size();  // the next one is compared with those that are left
}

std::string Scheduler::host_of(const std::string& worker) const {
  const auto found = state_.workers.find(worker);
  return found == state_.workers.end() ? "" : found->second.info.host;
}

std::string Scheduler::name_of(const std::string& worker) const {
  const auto found = state_.workers.find(worker);
  return found == state_.workers.end() ? "" : found->second.info.name;
}

std::string Scheduler::isa_for(const std::string& worker, std::string_view job) const {
  const auto found = state_.workers.find(worker);
  const absl::StatusOr<const FarmJob*> known = find_job(job);
  if (found == state_.workers.end() || !known.ok()) return "";
  const std::string* const name = classes_.class_for(found->second, **known);
  return name == nullptr ? "" : std::string(wire::isa_of(*name));
}

bool Scheduler::holds(std::string_view worker, const v1::LeaseToken& token) const {
  const absl::StatusOr<const FarmJob*> job = find_job(token.job_id());
  return job.ok() && (*job)->request.generation == token.generation() &&
         book_.find(**job, token, worker).has_value();
}

// ---------------------------------------------------------------- leases

absl::StatusOr<LeaseDecision> Scheduler::lease(const LeaseRequest& request, Time now) {
  const absl::StatusOr<FarmWorker*> worker = find_worker(request.worker, now);
  if (!worker.ok()) return worker.status();
  state_.turns.advance(now);
  return leasing_.lease(**worker, request, now);
}

absl::StatusOr<HeartbeatDecision> Scheduler::heartbeat(std::string_view worker_id,
                                                       const std::vector<v1::LeaseToken>& leases, Time now) {
  const absl::StatusOr<FarmWorker*> worker = find_worker(worker_id, now);
  if (!worker.ok()) return worker.status();
  HeartbeatDecision decision{.revoked = {}, .drain = (*worker)->draining};
  for (const v1::LeaseToken& token : leases) {
    const absl::StatusOr<FarmJob*> job = find_open_job(token);
    if (job.ok()) faults_.absolve(**job, token, (*worker)->info.host);
    const std::optional<UnitRun> units = job.ok() ? units_of(**job, token) : std::nullopt;
    const bool current = units && steps_.check_inputs(**job, token).ok();
    const std::optional<LeaseId> lease = current ? book_.find_own(**job, *units, worker_id) : std::nullopt;
    if (lease && state_.leases.get(*lease).spot == token.spot()) {
      state_.leases.refresh(*lease, now + book_.lease_time());
    } else if (!current || token.spot() != 0 || !leasing_.take_up(**worker, **job, *units, token, now)) {
      decision.revoked.push_back(token);
    }
  }
  return decision;
}

absl::Status Scheduler::fail(std::string_view worker_id, const v1::LeaseToken& token,
                             const FailureReport& report, Time now) {
  const absl::StatusOr<FarmWorker*> worker = find_worker(worker_id, now);
  if (!worker.ok()) return worker.status();
  const absl::StatusOr<FarmJob*> job = find_open_job(token);
  if (!job.ok()) return job.status();
  const std::optional<LeaseId> lease = book_.find(**job, token, worker_id);
  if (!lease) return absl::OkStatus();  // given up before: somebody else is at it
  const std::uint32_t unit = token.unit_index();
  const std::string why = absl::StrCat(short_name((*worker)->info.host), ": ", report.message);
  if (report.inputs_fault && audits_.suspect_inputs(**job, unit, why)) {
    if (state_.leases.contains(*lease)) book_.drop(*lease);
  } else {
    faults_.fail(**job, *lease, report, now);
    reconsider(**job, unit, why);
  }
  settle(**job, now);
  return absl::OkStatus();
}

/// A unit that was set aside may have failed for what it reads, whatever its workers say or died of.
void Scheduler::reconsider(FarmJob& job, std::uint32_t unit, const std::string& why) {
  if (job.open() && job.units.state(unit) == UnitState::kSetAside && !is_disputed(job.failures[unit]))
    static_cast<void>(audits_.suspect_inputs(job, unit, why));
}

/// Blames every unit that a lost worker held: it may have died of any.
void Scheduler::blame_losses(const std::vector<WorkerInfo>& lost, Time now) {
  if (faults_.is_mass_loss(lost.size())) return;
  for (const WorkerInfo& worker : lost) {
    for (const LeaseId id : state_.leases.of_worker(worker.id)) {
      if (!state_.leases.contains(id)) continue;  // its job ended over another of these units
      FarmJob& job = *state_.jobs_by_number.at(state_.leases.get(id).job);
      const std::uint32_t unit = state_.leases.get(id).units.first;
      if (!faults_.blame_loss(id, worker, now)) continue;
      reconsider(job, unit, absl::StrCat(short_name(worker.host), " was lost with it"));
      settle(job, now);
    }
  }
}

Expiry Scheduler::advance(Time now) {
  state_.turns.advance(now);
  Expiry expiry;
  const std::size_t before = state_.leases.size();
  const Time patience = book_.lease_time();
  for (const auto& [id, worker] : state_.workers) {
    if (now - worker.last_seen >= patience) expiry.lost_workers.push_back(worker.info);
  }
  // The same order in every run.
  std::sort(expiry.lost_workers.begin(), expiry.lost_workers.end(),
            [](const WorkerInfo& a, const WorkerInfo& b) { return a.id < b.id; });
  blame_losses(expiry.lost_workers, now);
  for (const WorkerInfo& lost : expiry.lost_workers) drop_worker(lost.id);
  while (const std::optional<LeaseId> lease = state_.leases.expired(now)) book_.drop(*lease);
  expiry.lost_leases = static_cast<std::uint32_t>(before - state_.leases.size());
  for (const auto& [number, job] : state_.jobs_by_number) {
    if (job->open()) bind_anew(*job, now);
  }
  // Workers who could have given second opinions may be gone.
  const std::set<std::uint64_t> auditing = state_.auditing;
  for (const std::uint64_t number : auditing) {
    FarmJob& job = *state_.jobs_by_number.at(number);
    job.audits.erase_if([](std::uint32_t, const Audit& audit) { return audit.is_over(); });
    settle(job, now);
    if (job.audits.empty()) state_.auditing.erase(number);
  }
  std::set<std::uint64_t> checking = state_.checking;
  checking.insert(auditing.begin(), auditing.end());
  for (const std::uint64_t number : checking) {
    FarmJob& job = *state_.jobs_by_number.at(number);
    if (job.open()) checks_.review(job, now);
    settle(job, now);
  }
  return expiry;
}

/// A job whose class has died out is rendered in another one; its results would be of two.
void Scheduler::bind_anew(FarmJob& job, Time now) {
  if (job.held() || !classes_.is_forsaken(job)) return job.forsaken_since.reset();
  if (!job.forsaken_since) job.forsaken_since = now;
  const Time patience = job.units.done() == 0 ? book_.lease_time() : state_.options.class_patience;
  if (now - *job.forsaken_since < patience) return;
  const std::string gone = job.classes.bound();
  const std::uint32_t done = job.units.done();
  steps_.revoke_all(job);
  if (job.audits.empty()) state_.auditing.erase(job.number);
  job.forsaken_since.reset();
  classes_.unbind(job);
  state_.note(job, absl::StrCat("no worker of class ", gone, " is left",
                                done == 0 ? "" : absl::StrCat("; ", done, " units are done again"),
                                " in another class"));
}

// ---------------------------------------------------------------- results

absl::Status Scheduler::check_may_complete(const FarmWorker& worker, const FarmJob& job) const {
  if (const std::optional<std::string> why = trust_.why_distrusted(worker.info.host)) {
    return absl::FailedPreconditionError(
        absl::StrCat("host ", short_name(worker.info.host), " is in quarantine: ", *why));
  }
  if (classes_.class_for(worker, job) == nullptr) {
    const std::string& bound = job.classes.bound();
    return absl::FailedPreconditionError(absl::StrCat("job ", job.request.id, " is bound to ",
                                                      bound.empty() ? job.request.isa : bound,
                                                      ", which this worker does not support"));
  }
  return absl::OkStatus();
}

absl::StatusOr<CompleteDecision> Scheduler::complete(std::string_view worker_id, const v1::LeaseToken& token,
                                                     const DeliveredResult& result, Time now) {
  const absl::StatusOr<FarmWorker*> found = find_worker(worker_id, now);
  if (!found.ok()) return found.status();
  FarmWorker& worker = **found;

  // The result of units that are done is compared, also after the end of the job.
  const absl::StatusOr<FarmJob*> known = find_job(token.job_id());
  if (!known.ok()) return known.status();
  const std::optional<UnitRun> units = units_of(**known, token);
  if (units) {
    if (absl::Status status = steps_.check_inputs(**known, token); !status.ok()) return status;
  }
  if (units && token.spot() != 0) return spot_result(**known, worker, token, result, now);
  if (units && token.generation() == (*known)->request.generation && any_done(**known, *units)) {
    return late_result(**known, worker, *units, token, result, now);
  }

  const absl::StatusOr<FarmJob*> open = find_open_job(token);
  if (!open.ok()) return open.status();
  FarmJob& job = **open;
  if (absl::Status status = check_may_complete(worker, job); !status.ok()) return status;

  // A lease of an earlier coordinator, whose choice of a class may be lost: what is accepted binds.
  classes_.bind(job, *classes_.class_for(worker, job));

  // Every lease of the units is over; this one's duration counts for the averages.
  std::optional<Time> lasted;
  bool doubtful = false;
  if (const std::optional<LeaseId> id = book_.find(job, token, worker_id)) {
    const Lease& lease = state_.leases.get(*id);
    if (lease.epoch == state_.options.epoch) lasted = now - lease.granted_at;
    doubtful = paces_.measure(job, worker, lease, result, now);
  }
  const AcceptedResult accepted{.fingerprint = result.fingerprint,
                                .sequence = ++job.results,
                                .host = state_.number_of_host(worker.info.host),
                                .units = *units};
  job.units.finish(accepted);
  classes_.note(job, worker.info.host, job.results, *classes_.class_for(worker, job));
  for (const std::uint32_t unit : *units) {
    for (const LeaseId lease : state_.leases.of_unit(job.number, unit)) book_.drop(lease);
    job.failures.erase(unit);
    job.shorter_runs.erase(unit);
    faults_.forgive(job, unit);
  }
  job.hosts.erase(worker.info.host);
  job.hosts_with_results.insert(accepted.host);
  job.state = v1::RUNNING;
  worker.units_done += units->count;
  audits_.ask(job, accepted);
  checks_.note(job, accepted, result.spot, doubtful, now);
  const std::uint32_t was_open = job.units.open_end();
  steps_.open(job);
  const CompleteDecision decision{.lasted = lasted,
                                  .threads = worker.info.threads,
                                  .sequence = job.results,
                                  .opened = job.units.open_end() > was_open};
  settle(job, now);
  return decision;
}

/// The result of a part of units that are done: whoever asked for it is told, and nobody else.
CompleteDecision Scheduler::spot_result(FarmJob& job, FarmWorker& worker, const v1::LeaseToken& token,
                                        const DeliveredResult& result, Time now) {
  const std::optional<LeaseId> id = book_.find(job, token, worker.info.id);
  if (!id || state_.leases.get(*id).spot != token.spot()) return {.duplicate = true};
  if (job.spots.find(token.unit_index()) != nullptr)
    checks_.compare(job, worker, token.unit_index(), result.fingerprint);
  if (state_.leases.contains(*id)) book_.drop(*id);
  settle(job, now);
  return {.duplicate = true};
}

bool Scheduler::any_done(const FarmJob& job, const UnitRun& units) {
  for (const std::uint32_t unit : units) {
    if (job.units.state(unit) == UnitState::kDone) return true;
  }
  return false;
}

/// A result of units some of which are done: compared where they came as one, too.
absl::StatusOr<CompleteDecision> Scheduler::late_result(FarmJob& job, FarmWorker& worker,
                                                        const UnitRun& units, const v1::LeaseToken& token,
                                                        const DeliveredResult& result, Time now) {
  const bool same_units =
      job.units.state(units.first) == UnitState::kDone && job.units.result(units.first).units == units;
  // Cut in another way, sums of the same samples can be neither merged nor compared.
  if (!same_units) return CompleteDecision{.duplicate = true};
  const std::optional<LeaseId> lease = book_.find(job, token, worker.info.id);
  if (lease) paces_.measure(job, worker, state_.leases.get(*lease), result, now);
  const Audits::Comparison found =
      audits_.compare(job, worker, job.units.result(units.first), result.fingerprint);
  if (found.confirmed) checks_.confirm(job, job.units.result(units.first), worker.info.host);
  if (found.heard) settle(job, now);
  if (lease && state_.leases.contains(*lease)) book_.drop(*lease);
  if (!found.same_class || found.equal) return CompleteDecision{.duplicate = true};
  return absl::AlreadyExistsError(
      absl::StrCat("unit ", units.first, " of job ", job.request.id,
                   " is done, with a different result: one of two workers is at fault"));
}

// ---------------------------------------------------------------- finding

absl::StatusOr<FarmWorker*> Scheduler::find_worker(std::string_view id, Time now) {
  const auto found = state_.workers.find(std::string(id));
  if (found == state_.workers.end()) return no_such_worker(id);
  found->second.last_seen = now;
  return &found->second;
}

absl::StatusOr<FarmJob*> Scheduler::find_open_job(const v1::LeaseToken& token) {
  absl::StatusOr<FarmJob*> job = find_open_job(token.job_id());
  if (!job.ok()) return job;
  if (token.generation() != (*job)->request.generation) {
    return absl::FailedPreconditionError(absl::StrCat("job ", token.job_id(), " is in generation ",
                                                      (*job)->request.generation, ", the lease in ",
                                                      token.generation()));
  }
  if (!units_of(**job, token)) {
    return absl::OutOfRangeError(
        absl::StrCat("job ", token.job_id(), " has no unit ", token.unit_index(),
                     token.ranges() > 1 ? absl::StrCat(" of ", token.ranges(), " ranges") : ""));
  }
  return job;
}

std::optional<UnitRun> Scheduler::units_of(const FarmJob& job, const v1::LeaseToken& token) {
  return job.request.plan->run(token.unit_index(), std::max(token.ranges(), 1u));
}

}  // namespace tessera::server
