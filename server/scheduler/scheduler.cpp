// Jobs, workers and results. Who gets which unit is in scheduler_leasing.cpp, what follows from failures in
// scheduler_faults.cpp, second opinions in scheduler_audit.cpp.
#include "scheduler/scheduler.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "scheduler/identity.h"
#include "wire/arithmetic_class.h"

namespace tessera::server {
namespace {

absl::Status no_such_job(std::string_view id) {
  return absl::NotFoundError(absl::StrCat("there is no job ", std::string(id)));
}

absl::Status no_such_worker(std::string_view id) {
  return absl::NotFoundError(absl::StrCat("worker ", std::string(id), " is not known; register again"));
}

const char* past_tense(v1::JobState state) {
  switch (state) {
    case v1::CANCELLED:
      return "was cancelled";
    case v1::FAILED:
      return "failed";
    case v1::INCOMPLETE:
      return "is over, though incomplete";
    default:
      return "is done";
  }
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

// ---------------------------------------------------------------- jobs

absl::Status Scheduler::add_job(JobRequest request) {
  if (jobs_by_id_.contains(request.id)) return absl::AlreadyExistsError(absl::StrCat("there is a job ", request.id));
  auto job = std::make_unique<Job>(jobs_added_++, std::move(request));
  jobs_by_id_.emplace(job->request.id, job.get());
  take_turns(*job);
  jobs_.emplace(job->number, std::move(job));
  return absl::OkStatus();
}

absl::Status Scheduler::adopt(std::string_view id, const std::string& from, const std::vector<AdoptedResult>& results) {
  const absl::StatusOr<Job*> found = find_job(id);
  if (!found.ok()) return found.status();
  Job& job = **found;
  const bool fit = std::all_of(results.begin(), results.end(), [&](const AdoptedResult& result) {
    const std::string& name = result.arithmetic_class;
    return (job.request.any_class || name == results.front().arithmetic_class) &&
           (job.request.isa.empty() || job.request.isa == wire::isa_of(name));
  });
  if (job.results > 0 || !fit) {
    return absl::FailedPreconditionError(
        absl::StrCat("job ", job.request.id, " is not new, or is bound to another ISA or class than job ", from));
  }
  if (results.empty()) return absl::OkStatus();
  bind(job, results.front().arithmetic_class);
  for (const AdoptedResult& result : results) {
    job.units.finish({.fingerprint = result.fingerprint,
                      .sequence = ++job.results,
                      .host = number_of_host(result.host),
                      .units = result.units});
    job.renderers.insert(number_of_host(result.host));
    note_class(job, result.host, job.results, result.arithmetic_class);
  }
  job.state = v1::RUNNING;
  job.adopted = job.units.done();
  job.adopted_from = from;
  FarmEvent& event = record(FarmEvent::Kind::kAdopted, job.request.id);
  event.value = job.adopted;
  event.text = from;
  settle(job);
  return absl::OkStatus();
}

/// An open job takes its turns, unless it is paused.
void Scheduler::take_turns(Job& job) {
  leave_turns(job);
  if (!job.open() || job.paused) return;
  turns_.add(job.number, job.request.priority, job.request.user, job.load_ms);
  jobs_by_scene_[job.request.scene_digest].insert(job.number);
}

void Scheduler::leave_turns(const Job& job) {
  turns_.remove(job.number);
  const auto scene = jobs_by_scene_.find(job.request.scene_digest);
  if (scene == jobs_by_scene_.end()) return;
  scene->second.erase(job.number);
  if (scene->second.empty()) jobs_by_scene_.erase(scene);
}

absl::StatusOr<bool> Scheduler::cancel_job(std::string_view id) {
  const absl::StatusOr<Job*> job = find_job(id);
  if (!job.ok()) return job.status();
  if (!(*job)->open()) return false;
  end_job(**job, v1::CANCELLED, "");
  return true;
}

absl::Status Scheduler::pause_job(std::string_view id, bool paused) {
  const absl::StatusOr<Job*> found = find_job(id);
  if (!found.ok()) return found.status();
  Job& job = **found;
  if (!job.open())
    return absl::FailedPreconditionError(absl::StrCat("job ", job.request.id, " ", past_tense(job.state)));
  if (job.paused == paused) return absl::OkStatus();
  job.paused = paused;
  take_turns(job);
  record(FarmEvent::Kind::kPaused, job.request.id).value = paused;
  return absl::OkStatus();
}

absl::Status Scheduler::set_priority(std::string_view id, std::int32_t priority) {
  const absl::StatusOr<Job*> found = find_job(id);
  if (!found.ok()) return found.status();
  Job& job = **found;
  if (!job.open())
    return absl::FailedPreconditionError(absl::StrCat("job ", job.request.id, " ", past_tense(job.state)));
  if (job.request.priority == priority) return absl::OkStatus();
  job.request.priority = priority;
  take_turns(job);
  record(FarmEvent::Kind::kPriority, job.request.id).value = priority;
  return absl::OkStatus();
}

absl::Status Scheduler::forget_job(std::string_view id) {
  const absl::StatusOr<Job*> job = find_job(id);
  if (!job.ok()) return job.status();
  if ((*job)->open()) return absl::FailedPreconditionError(absl::StrCat("job ", std::string(id), " is not over"));
  const std::uint64_t number = (*job)->number;
  jobs_by_id_.erase((*job)->request.id);
  jobs_.erase(number);
  return absl::OkStatus();
}

absl::StatusOr<JobView> Scheduler::job(std::string_view id) const {
  const absl::StatusOr<const Job*> found = find_job(id);
  if (!found.ok()) return found.status();
  const Job& job = **found;
  const UnitLedger& units = job.units;
  JobView view{.state = job.state,
               .units_total = units.count(),
               .units_done = units.done(),
               .units_leased = units.count() - units.done() - units.pending() - units.set_aside(),
               .units_set_aside = units.set_aside(),
               .isa = job.request.isa,
               .error = job.error,
               .priority = job.request.priority,
               .paused = job.paused,
               .revision = job.revision,
               .notes = job.notes,
               .set_aside = {},
               .audits = static_cast<std::uint32_t>(job.audited.size()),
               .audits_out = static_cast<std::uint32_t>(std::count_if(
                   job.audits.begin(), job.audits.end(), [](const auto& entry) { return entry.second.out; })),
               .units_adopted = job.adopted,
               .adopted_from = job.adopted_from,
               .classes = job.classes.all(),
               .workers = static_cast<std::uint32_t>(job.holders.size())};
  if (!view.classes.empty()) view.isa = isas_of(view.classes);
  if (units.set_aside() == 0) return view;
  for (const auto& [unit, failures] : job.failures) {
    if (units.state(unit) == UnitState::kSetAside) view.set_aside.push_back({unit, failures});
  }
  std::sort(view.set_aside.begin(), view.set_aside.end(),
            [](const SetAsideView& a, const SetAsideView& b) { return a.unit < b.unit; });
  if (view.set_aside.size() > kMaxListed) view.set_aside.resize(kMaxListed);
  return view;
}

std::string Scheduler::waiting_for(std::string_view id, Time now) const {
  const absl::StatusOr<const Job*> found = find_job(id);
  if (!found.ok() || !(*found)->open() || (*found)->leases > 0) return "";
  const Job& job = **found;
  if (job.paused) return "the job is paused";
  if (workers_.empty()) return "there is no worker";
  std::size_t with_tags = 0, with_isa = 0, free = 0;
  for (const auto& [name, worker] : workers_) {
    if (worker.draining || !trusts(worker.info.host)) continue;
    if (!has_tags(worker.info, job.request.required_tags)) continue;
    ++with_tags;
    if (class_for(worker, job) == nullptr) continue;
    ++with_isa;
    free += may_work_on(worker, job, now);
  }
  if (with_tags == 0)
    return job.request.required_tags.empty() ? "every worker drains or is in quarantine"
                                             : "no worker has the tags that the job requires";
  if (with_isa == 0) {
    const std::string& bound = job.classes.bound();
    return bound.empty() ? absl::StrCat("no worker supports ", job.request.isa)
                         : absl::StrCat("the job is bound to ", bound, ", and no worker of that class is left");
  }
  if (settling(job, now)) return "workers have only just come; it is bound to the class of most of them in a moment";
  if (free == 0) return "the job failed on every host that could take it; they are tried again later";
  return "other jobs go first, or the workers are still busy";
}

void Scheduler::end_job(Job& job, v1::JobState state, std::string error) {
  for (const LeaseId id : job.leases > 0 ? leases_.of_job(job.number) : std::vector<LeaseId>{}) drop_lease(id);
  leave_turns(job);
  auditing_.erase(job.number);
  endangered_.erase(job.number);
  job.state = state;
  job.error = std::move(error);
  job.audits.clear();
  job.dangerous.clear();
  job.shorter_runs.clear();
  job.tile_cost_ms = {};
  job.hosts.clear();
  job.scene_faults.clear();
  job.renderers.clear();
  // The failures of an incomplete job are what its report consists of.
  if (state != v1::INCOMPLETE) job.failures.clear();
  FarmEvent& event = record(FarmEvent::Kind::kEnded, job.request.id);
  event.value = state;
  event.text = job.error;
}

void Scheduler::settle(Job& job) {
  if (!job.open() || !job.units.settled()) return;
  std::erase_if(job.audits, [&](const auto& entry) {
    const auto& [unit, audit] = entry;
    if (audit.out || anyone_can_audit(job, audit)) return false;
    if (audit.opinions.size() > 1) {
      note(job, absl::StrCat("unit ", unit, ": ", short_name(audit.opinions[0].first), " and ",
                             short_name(audit.opinions[1].first), " disagree, and there is no third host to decide"));
    }
    return true;
  });
  if (!job.audits.empty()) return;
  if (job.units.set_aside() == 0) return end_job(job, v1::DONE, "");
  end_job(job, job.units.done() == 0 ? v1::FAILED : v1::INCOMPLETE, what_is_missing(job));
}

// ---------------------------------------------------------------- recovery

absl::Status Scheduler::restore_done(std::string_view id, const AcceptedResult& result) {
  const absl::StatusOr<Job*> job = find_job(id);
  if (!job.ok()) return job.status();
  UnitLedger& units = (*job)->units;
  for (const std::uint32_t unit : result.units) {
    if (unit < units.count() && units.state(unit) != UnitState::kDone) continue;
    return absl::InvalidArgumentError(absl::StrCat("job ", std::string(id), " has no unit ", unit, " left to be done"));
  }
  units.finish(result);
  (*job)->renderers.insert(result.host);
  (*job)->results = std::max((*job)->results, result.sequence);
  (*job)->state = v1::RUNNING;
  return absl::OkStatus();
}

absl::Status Scheduler::restore_revoked(std::string_view id, std::uint32_t sequence) {
  const absl::StatusOr<Job*> job = find_job(id);
  if (!job.ok()) return job.status();
  (*job)->results = std::max((*job)->results, sequence);
  ++(*job)->revision;
  return absl::OkStatus();
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
  const bool added = workers_.emplace(id, Worker{.info = std::move(info), .last_seen = now, .pace = pace}).second;
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
    for (const auto& [worker, leases] : job->holders) assignments.push_back({job->request.id, worker, leases});
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
  return job.ok() && (*job)->request.generation == token.generation() && find_lease(**job, token, worker).has_value();
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
    job.audits[units->first] = first_opinion(job, accepted);
    auditing_.insert(job.number);
  }
  const CompleteDecision decision{.sequence = job.results};
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
                                                        const v1::LeaseToken& token, const DeliveredResult& result,
                                                        Time now) {
  const bool same_units =
      job.units.state(units.first) == UnitState::kDone && job.units.result(units.first).units == units;
  // Cut in another way, sums of the same samples can be neither merged nor compared.
  if (!same_units) return CompleteDecision{.duplicate = true};
  const std::optional<LeaseId> lease = find_lease(job, token, worker.info.id);
  if (lease) measure(job, worker, leases_.get(*lease), result, now);
  const absl::StatusOr<CompleteDecision> decision =
      second_result(job, worker, job.units.result(units.first), result.fingerprint);
  if (lease && leases_.contains(*lease)) drop_lease(*lease);
  return decision;
}

/// Takes one finished lease into the averages of its job and the pace of its worker.
void Scheduler::measure(Job& job, Worker& worker, const Lease& lease, const DeliveredResult& result, Time now) {
  const Time duration = std::max(Time{1}, now - lease.granted_at);
  const bool told = result.cost.count() > 0 && result.cost <= duration + Time{1};
  const std::chrono::nanoseconds cost = told ? result.cost : duration;
  if (told) {
    // Without a measure of the work, all units count alike.
    const auto work = static_cast<double>(result.work > 0 ? result.work : lease.units.count);
    job.pace.compare(worker.pace, usual_pace_, std::log(static_cast<double>(cost.count()) / work));
    worker.slowness = slowness_of(worker.pace, usual_pace_);
    if (++results_since_comparison_ > workers_.size() / 4) compare_workers();
  }
  // What a slow worker needs says little of the unit.
  const double usual_ms = std::chrono::duration<double, std::milli>(cost).count() / lease.units.count / worker.slowness;
  job.mean_cost_ms = job.mean_cost_ms == 0 ? usual_ms : (7 * job.mean_cost_ms + usual_ms) / 8;
  const std::uint32_t tiles = lease.units.step;
  if (job.units.count() > tiles) {
    job.tile_cost_ms.resize(tiles);
    job.tile_cost_ms[lease.units.first % tiles] = static_cast<float>(usual_ms);
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

absl::StatusOr<const Scheduler::Job*> Scheduler::find_job(std::string_view id) const {
  const auto found = jobs_by_id_.find(std::string(id));
  if (found == jobs_by_id_.end()) return no_such_job(id);
  return found->second;
}

absl::StatusOr<Scheduler::Job*> Scheduler::find_job(std::string_view id) {
  const auto found = jobs_by_id_.find(std::string(id));
  if (found == jobs_by_id_.end()) return no_such_job(id);
  return found->second;
}

absl::StatusOr<Scheduler::Worker*> Scheduler::find_worker(std::string_view id, Time now) {
  const auto found = workers_.find(std::string(id));
  if (found == workers_.end()) return no_such_worker(id);
  found->second.last_seen = now;
  return &found->second;
}

absl::StatusOr<Scheduler::Job*> Scheduler::find_open_job(const v1::LeaseToken& token) {
  const absl::StatusOr<Job*> job = find_job(token.job_id());
  if (!job.ok()) return job.status();
  if (!(*job)->open()) {
    return absl::FailedPreconditionError(absl::StrCat("job ", token.job_id(), " ", past_tense((*job)->state)));
  }
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
    if (same_units && lease.attempt == token.attempt() && lease.epoch == token.epoch() && lease.worker == worker)
      return id;
  }
  return std::nullopt;
}

}  // namespace tessera::server
