// Workers and results. Jobs are in scheduler_jobs.cpp, who gets which unit in scheduler_leasing.cpp, what
// follows from failures in scheduler_faults.cpp, second opinions in scheduler_audit.cpp.
#include "scheduler/scheduler.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "scheduler/identity.h"

namespace tessera::server {
namespace {

absl::Status no_such_worker(std::string_view id) {
  return absl::NotFoundError(absl::StrCat("worker ", std::string(id), " is not known; register again"));
}

}  // namespace

Scheduler::Scheduler(const SchedulerOptions& options) : options_(options), turns_(options.order) {}

FarmEvent& Scheduler::record(FarmEvent::Kind kind, const std::string& job) {
  FarmEvent& event = events_.emplace_back();
  event.kind = kind;
  event.job = job;
  return event;
}

void Scheduler::note(Job& job, std::string text) {
  if (job.notes.size() >= kMaxListed) return;
  record(FarmEvent::Kind::kNote, job.request.id).text = text;
  job.notes.push_back(std::move(text));
}

// ---------------------------------------------------------------- workers

absl::Status Scheduler::register_worker(WorkerInfo info, Time now) {
  if (info.host.empty()) info.host = info.name;
  if (info.classes.empty()) info.classes = info.supported_isas;
  const std::string id = info.id;
  const std::string identity = identity_of(info.host);
  const std::uint32_t threads = info.threads;
  // Until results show otherwise, it is as fast as the others.
  const WorkerPace pace{.worker = ++workers_added_, .log_time = usual_pace_.log_time};
  const bool added =
      workers_.emplace(id, Worker{.info = std::move(info), .last_seen = now, .pace = pace}).second;
  if (!added) return absl::AlreadyExistsError(absl::StrCat("there is a worker ", id));
  threads_ += threads;
  ++identities_[identity];
  Worker& worker = workers_.at(id);
  if (!census_.has(worker.info.classes)) settled_at_ = now + options_.settle;
  count(worker);
  return absl::OkStatus();
}

absl::Status Scheduler::deregister_worker(std::string_view worker) {
  if (!workers_.contains(std::string(worker))) return no_such_worker(worker);
  drop_worker(worker);
  return absl::OkStatus();
}

absl::Status Scheduler::drain_worker(std::string_view worker) {
  const auto found = workers_.find(std::string(worker));
  if (found == workers_.end()) return no_such_worker(worker);
  found->second.draining = true;
  count(found->second);
  return absl::OkStatus();
}

std::vector<WorkerView> Scheduler::workers() const {
  std::vector<WorkerView> views;
  // Machines of one kind may work on the same jobs.
  std::map<std::pair<std::vector<std::string>, std::vector<std::string>>, std::vector<std::string>> closed;
  for (const auto& [id, worker] : workers_) {
    const auto [kind, is_new] = closed.try_emplace({worker.info.classes, worker.info.tags});
    if (is_new) kind->second = closed_jobs(worker);
    views.push_back({.info = worker.info,
                     .leases = static_cast<std::uint32_t>(leases_.count_of_worker(id)),
                     .units_done = worker.units_done,
                     .draining = worker.draining,
                     .last_seen = worker.last_seen,
                     .quarantine = why_distrusted(worker.info.host).value_or(""),
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
  for (const auto& [number, job] : jobs_) {
    for (const auto& [worker, leases] : job->holders)
      assignments.push_back({job->request.id, worker, leases});
  }
  return assignments;
}

void Scheduler::drop_worker(std::string_view id) {
  const std::string worker(id);
  for (const LeaseId lease : leases_.of_worker(worker)) drop_lease(lease);
  const auto found = workers_.find(worker);
  threads_ -= found->second.info.threads;
  const auto identity = identities_.find(identity_of(found->second.info.host));
  if (--identity->second == 0) identities_.erase(identity);
  freeing_.erase(worker);
  if (found->second.counted) census_.remove(found->second.info);
  workers_.erase(found);
  results_since_comparison_ = workers_.size();  // the next one is compared with those that are left
}

std::string Scheduler::host_of(const std::string& worker) const {
  const auto found = workers_.find(worker);
  return found == workers_.end() ? "" : found->second.info.host;
}

std::string Scheduler::name_of(const std::string& worker) const {
  const auto found = workers_.find(worker);
  return found == workers_.end() ? "" : found->second.info.name;
}

bool Scheduler::holds(std::string_view worker, const v1::LeaseToken& token) const {
  const absl::StatusOr<const Job*> job = find_job(token.job_id());
  return job.ok() && (*job)->request.generation == token.generation() &&
         find_lease(**job, token, worker).has_value();
}

HostNumber Scheduler::number_of_host(const std::string& host) {
  const auto [found, added] = host_numbers_.emplace(host, static_cast<HostNumber>(hosts_.size()));
  if (added) hosts_.push_back(host);
  return found->second;
}

// ---------------------------------------------------------------- results

absl::Status Scheduler::check_may_complete(const Worker& worker, const Job& job) const {
  if (const std::optional<std::string> why = why_distrusted(worker.info.host)) {
    return absl::FailedPreconditionError(
        absl::StrCat("host ", short_name(worker.info.host), " is in quarantine: ", *why));
  }
  if (class_for(worker, job) == nullptr) {
    const std::string& bound = job.classes.bound();
    return absl::FailedPreconditionError(absl::StrCat("job ", job.request.id, " is bound to ",
                                                      bound.empty() ? job.request.isa : bound,
                                                      ", which this worker does not support"));
  }
  return absl::OkStatus();
}

absl::StatusOr<CompleteDecision> Scheduler::complete(std::string_view worker_id, const v1::LeaseToken& token,
                                                     const DeliveredResult& result, Time now) {
  const absl::StatusOr<Worker*> found = find_worker(worker_id, now);
  if (!found.ok()) return found.status();
  Worker& worker = **found;

  // The result of units that are done is compared, also after the end of the job.
  const absl::StatusOr<Job*> known = find_job(token.job_id());
  if (!known.ok()) return known.status();
  const std::optional<UnitRun> units = units_of(**known, token);
  if (units) {
    if (absl::Status status = check_inputs(**known, token); !status.ok()) return status;
  }
  if (units && token.generation() == (*known)->request.generation && any_done(**known, *units)) {
    return late_result(**known, worker, *units, token, result, now);
  }

  const absl::StatusOr<Job*> open = find_open_job(token);
  if (!open.ok()) return open.status();
  Job& job = **open;
  if (absl::Status status = check_may_complete(worker, job); !status.ok()) return status;

  // A lease of an earlier coordinator, whose choice of a class may be lost: what is accepted binds.
  bind(job, *class_for(worker, job));

  // Every lease of the units is over; this one's duration counts for the averages.
  if (const std::optional<LeaseId> lease = find_lease(job, token, worker_id)) {
    measure(job, worker, leases_.get(*lease), result, now);
  }
  const AcceptedResult accepted{.fingerprint = result.fingerprint,
                                .sequence = ++job.results,
                                .host = number_of_host(worker.info.host),
                                .units = *units};
  job.units.finish(accepted);
  note_class(job, worker.info.host, job.results, *class_for(worker, job));
  for (const std::uint32_t unit : *units) {
    for (const LeaseId lease : leases_.of_unit(job.number, unit)) drop_lease(lease);
    job.failures.erase(unit);
    job.shorter_runs.erase(unit);
    forgive(job, unit);
  }
  job.hosts.erase(worker.info.host);
  job.renderers.insert(accepted.host);
  job.state = v1::RUNNING;
  worker.units_done += units->count;
  if (audit_wanted(job, accepted)) {
    job.audits.put(units->first, first_opinion(job, accepted));
    auditing_.insert(job.number);
  }
  const std::uint32_t was_open = job.units.open_end();
  open_steps(job);
  const CompleteDecision decision{.sequence = job.results, .opened = job.units.open_end() > was_open};
  settle(job);
  return decision;
}

bool Scheduler::any_done(const Job& job, const UnitRun& units) {
  for (const std::uint32_t unit : units) {
    if (job.units.state(unit) == UnitState::kDone) return true;
  }
  return false;
}

/// A result of units some of which are done: compared where they came as one, too.
absl::StatusOr<CompleteDecision> Scheduler::late_result(Job& job, Worker& worker, const UnitRun& units,
                                                        const v1::LeaseToken& token,
                                                        const DeliveredResult& result, Time now) {
  const bool same_units =
      job.units.state(units.first) == UnitState::kDone && job.units.result(units.first).units == units;
  // Cut in another way, sums of the same samples can be neither merged nor compared.
  if (!same_units) return CompleteDecision{.duplicate = true};
  const std::optional<LeaseId> lease = find_lease(job, token, worker.info.id);
  if (lease) measure(job, worker, leases_.get(*lease), result, now);
  absl::StatusOr<CompleteDecision> decision =
      second_result(job, worker, job.units.result(units.first), result.fingerprint);
  if (lease && leases_.contains(*lease)) drop_lease(*lease);
  return decision;
}

/// Takes one finished lease into the averages of its job and the pace of its worker.
void Scheduler::measure(Job& job, Worker& worker, const Lease& lease, const DeliveredResult& result,
                        Time now) {
  const Time duration = std::max(Time{1}, now - lease.granted_at);
  const bool told = result.cost.count() > 0 && result.cost <= duration + Time{1};
  const std::chrono::nanoseconds cost = told ? result.cost : duration;
  const WorkPlan& plan = *job.request.plan;
  const bool of_picture = plan.is_of_picture(lease.units.first);
  // Units of other steps do work of another kind.
  if (told && of_picture) {
    // Without a measure of the work, all units count alike.
    const auto work = static_cast<double>(result.work > 0 ? result.work : lease.units.count);
    job.pace.compare(worker.pace, usual_pace_, std::log(static_cast<double>(cost.count()) / work));
    worker.slowness = slowness_of(worker.pace, usual_pace_);
    if (++results_since_comparison_ > workers_.size() / 4) compare_workers();
  }
  // What a slow worker needs says little of the unit.
  const double usual_ms =
      std::chrono::duration<double, std::milli>(cost).count() / lease.units.count / worker.slowness;
  job.mean_cost_ms = job.mean_cost_ms == 0 ? usual_ms : (7 * job.mean_cost_ms + usual_ms) / 8;
  if (of_picture && plan.unit_count() - plan.phases().unit_count() > plan.tile_count()) {
    job.tile_cost_ms.resize(plan.tile_count());
    job.tile_cost_ms[plan.tile_of(lease.units.first)] = static_cast<float>(usual_ms);
  }
  turns_.remember(job.number, lease.charge_ms, now);
  job.mean_duration = job.mean_duration == Time{0} ? duration : (7 * job.mean_duration + duration) / 8;
}

/// Finds the usual pace anew, and each worker's relative to it.
void Scheduler::compare_workers() {
  results_since_comparison_ = 0;
  std::vector<const WorkerPace*> paces;
  paces.reserve(workers_.size());
  for (const auto& [id, worker] : workers_) paces.push_back(&worker.pace);
  usual_pace_ = usual_pace(paces);
  for (auto& [id, worker] : workers_) worker.slowness = slowness_of(worker.pace, usual_pace_);
}

// ---------------------------------------------------------------- finding

absl::StatusOr<Scheduler::Worker*> Scheduler::find_worker(std::string_view id, Time now) {
  const auto found = workers_.find(std::string(id));
  if (found == workers_.end()) return no_such_worker(id);
  found->second.last_seen = now;
  return &found->second;
}

absl::StatusOr<Scheduler::Job*> Scheduler::find_open_job(const v1::LeaseToken& token) {
  absl::StatusOr<Job*> job = find_open_job(token.job_id());
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

std::optional<UnitRun> Scheduler::units_of(const Job& job, const v1::LeaseToken& token) {
  return job.request.plan->run(token.unit_index(), std::max(token.ranges(), 1u));
}

std::optional<LeaseId> Scheduler::find_lease(const Job& job, const v1::LeaseToken& token,
                                             std::string_view worker) const {
  for (const LeaseId id : leases_.of_unit(job.number, token.unit_index())) {
    const Lease& lease = leases_.get(id);
    const bool same_units =
        lease.units.first == token.unit_index() && lease.units.count == std::max(token.ranges(), 1u);
    if (same_units && lease.attempt == token.attempt() && lease.epoch == token.epoch() &&
        lease.worker == worker)
      return id;
  }
  return std::nullopt;
}

}  // namespace tessera::server
