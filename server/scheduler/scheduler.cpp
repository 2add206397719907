// Jobs, workers and results. Who gets which unit is in scheduler_leasing.cpp.
#include "scheduler/scheduler.h"

#include <algorithm>

#include "absl/strings/str_cat.h"

namespace tessera::server {
namespace {

absl::Status no_such_job(std::string_view id) {
  return absl::NotFoundError(absl::StrCat("there is no job ", std::string(id)));
}

absl::Status no_such_worker(std::string_view id) {
  return absl::NotFoundError(absl::StrCat("worker ", std::string(id), " is not known; register again"));
}

const char* past_tense(v1::JobState state) {
  return state == v1::CANCELLED ? "was cancelled" : state == v1::FAILED ? "failed" : "is done";
}

}  // namespace

Scheduler::Scheduler(const SchedulerOptions& options) : options_(options) {}

bool Scheduler::Worker::supports(const std::string& isa) const {
  return std::find(info.supported_isas.begin(), info.supported_isas.end(), isa) != info.supported_isas.end();
}

// ---------------------------------------------------------------- jobs

absl::Status Scheduler::add_job(JobRequest request) {
  if (jobs_by_id_.contains(request.id)) return absl::AlreadyExistsError(absl::StrCat("there is a job ", request.id));
  auto job = std::make_unique<Job>(jobs_.size(), std::move(request));
  jobs_by_id_.emplace(job->request.id, job.get());
  turns_.insert(turn(*job));
  jobs_.push_back(std::move(job));
  return absl::OkStatus();
}

absl::Status Scheduler::restore_done(std::string_view id, std::uint32_t unit, ResultFingerprint result) {
  const absl::StatusOr<Job*> job = find_job(id);
  if (!job.ok()) return job.status();
  UnitLedger& units = (*job)->units;
  if (unit >= units.count() || units.state(unit) == UnitState::kDone) {
    return absl::InvalidArgumentError(absl::StrCat("job ", std::string(id), " has no unit ", unit, " left to be done"));
  }
  units.finish(unit, result);
  (*job)->state = v1::RUNNING;
  if (units.done() == units.count()) end_job(**job, v1::DONE, "");
  return absl::OkStatus();
}

absl::StatusOr<bool> Scheduler::cancel_job(std::string_view id) {
  const absl::StatusOr<Job*> job = find_job(id);
  if (!job.ok()) return job.status();
  if (!(*job)->open()) return false;
  end_job(**job, v1::CANCELLED, "");
  return true;
}

absl::StatusOr<JobView> Scheduler::job(std::string_view id) const {
  const absl::StatusOr<const Job*> found = find_job(id);
  if (!found.ok()) return found.status();
  const Job& job = **found;
  return JobView{.state = job.state,
                 .units_total = job.units.count(),
                 .units_done = job.units.done(),
                 .units_leased = job.units.count() - job.units.done() - job.units.pending(),
                 .isa = job.request.isa,
                 .error = job.error};
}

void Scheduler::end_job(Job& job, v1::JobState state, std::string error) {
  for (const LeaseId id : job.leases > 0 ? leases_.of_job(job.number) : std::vector<LeaseId>{}) drop_lease(id);
  turns_.erase(turn(job));
  job.state = state;
  job.error = std::move(error);
  job.failures.clear();
}

// ---------------------------------------------------------------- workers

absl::Status Scheduler::register_worker(WorkerInfo info, Time now) {
  const std::string id = info.id;
  const bool added = workers_.emplace(id, Worker{.info = std::move(info), .last_seen = now}).second;
  return added ? absl::OkStatus() : absl::AlreadyExistsError(absl::StrCat("there is a worker ", id));
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
  return absl::OkStatus();
}

std::vector<WorkerView> Scheduler::workers() const {
  std::vector<WorkerView> views;
  for (const auto& [id, worker] : workers_) {
    views.push_back({.info = worker.info,
                     .leases = static_cast<std::uint32_t>(leases_.count_of_worker(id)),
                     .units_done = worker.units_done,
                     .draining = worker.draining,
                     .last_seen = worker.last_seen});
  }
  std::sort(views.begin(), views.end(), [](const WorkerView& a, const WorkerView& b) {
    return std::tie(a.info.name, a.info.id) < std::tie(b.info.name, b.info.id);
  });
  return views;
}

void Scheduler::drop_worker(std::string_view id) {
  const std::string worker(id);
  for (const LeaseId lease : leases_.of_worker(worker)) drop_lease(lease);
  workers_.erase(worker);
}

// ---------------------------------------------------------------- results

absl::StatusOr<CompleteDecision> Scheduler::complete(std::string_view worker_id, const v1::LeaseToken& token,
                                                     ResultFingerprint result, Time now) {
  const absl::StatusOr<Worker*> worker = find_worker(worker_id, now);
  if (!worker.ok()) return worker.status();

  // The result of a unit that is done is compared, also after the end of the job.
  const absl::StatusOr<Job*> known = find_job(token.job_id());
  if (!known.ok()) return known.status();
  UnitLedger& units = (*known)->units;
  const std::uint32_t unit = token.unit_index();
  if (token.generation() == (*known)->request.generation && unit < units.count() &&
      units.state(unit) == UnitState::kDone) {
    if (units.result(unit) == result) return CompleteDecision{.duplicate = true};
    return absl::AlreadyExistsError(absl::StrCat("unit ", unit, " of job ", token.job_id(),
                                                 " is done, with a different result: one of two workers is at fault"));
  }

  const absl::StatusOr<Job*> open = find_open_job(token);
  if (!open.ok()) return open.status();
  Job& job = **open;
  if (!job.request.isa.empty() && !(*worker)->supports(job.request.isa)) {
    return absl::FailedPreconditionError(
        absl::StrCat("job ", token.job_id(), " is bound to ", job.request.isa, ", which this worker does not support"));
  }

  // Any lease of the unit is over, this one's duration counts for the average.
  if (const std::optional<LeaseId> lease = find_lease(job, token, worker_id)) {
    const Time duration = std::max(Time{1}, now - leases_.get(*lease).granted_at);
    job.mean_duration = job.mean_duration == Time{0} ? duration : (7 * job.mean_duration + duration) / 8;
  }
  units.finish(unit, result);
  for (const LeaseId lease : leases_.of_unit(job.number, unit)) drop_lease(lease);
  job.failures.erase(unit);
  job.state = v1::RUNNING;
  ++(*worker)->units_done;

  const CompleteDecision decision{.sequence = units.done(), .job_done = units.done() == units.count()};
  if (decision.job_done) end_job(job, v1::DONE, "");
  return decision;
}

absl::StatusOr<FailDecision> Scheduler::fail(std::string_view worker_id, const v1::LeaseToken& token,
                                             const std::string& message, bool scene_fault, Time now) {
  const absl::StatusOr<Worker*> worker = find_worker(worker_id, now);
  if (!worker.ok()) return worker.status();
  const absl::StatusOr<Job*> open = find_open_job(token);
  if (!open.ok()) return open.status();
  Job& job = **open;
  const std::uint32_t unit = token.unit_index();
  if (scene_fault) {
    end_job(job, v1::FAILED, message);
    return FailDecision{.job_failed = true};
  }

  const std::optional<LeaseId> lease = find_lease(job, token, worker_id);
  if (!lease) return FailDecision{};  // given up before: somebody else is at it
  Failures& failures = job.failures[unit];
  ++failures.count;
  failures.workers.emplace_back(worker_id);
  drop_lease(*lease);
  if (failures.count < kMaxFailures) return FailDecision{};
  end_job(job, v1::FAILED,
          absl::StrCat("unit ", unit, " failed ", kMaxFailures, " times, the last time on ", (*worker)->info.name, ": ",
                       message));
  return FailDecision{.job_failed = true};
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
  if (token.unit_index() >= (*job)->units.count()) {
    return absl::OutOfRangeError(absl::StrCat("job ", token.job_id(), " has no unit ", token.unit_index()));
  }
  return job;
}

std::optional<LeaseId> Scheduler::find_lease(const Job& job, const v1::LeaseToken& token,
                                             std::string_view worker) const {
  for (const LeaseId id : leases_.of_unit(job.number, token.unit_index())) {
    const Lease& lease = leases_.get(id);
    if (lease.attempt == token.attempt() && lease.epoch == token.epoch() && lease.worker == worker) return id;
  }
  return std::nullopt;
}

}  // namespace tessera::server
