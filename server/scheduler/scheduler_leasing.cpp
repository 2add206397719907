// Who gets which unit, for how long.
#include <algorithm>

#include "scheduler/scheduler.h"
#include "wire/limits.h"

namespace tessera::server {
struct Scheduler::Batch {
  Worker& worker;
  Time now;
  std::vector<std::string> scenes;         // that the worker holds, or will hold after this batch
  std::vector<const Job*> nothing_for_it;  // jobs whose pending units are not for this worker
  LeaseDecision decision;
};

// ---------------------------------------------------------------- granting

absl::StatusOr<LeaseDecision> Scheduler::lease(const LeaseRequest& request, Time now) {
  const absl::StatusOr<Worker*> worker = find_worker(request.worker, now);
  if (!worker.ok()) return worker.status();
  Batch batch{.worker = **worker, .now = now, .scenes = request.loaded_scenes, .nothing_for_it = {}, .decision = {}};
  if (batch.worker.draining) return LeaseDecision{};

  const std::size_t held = leases_.count_of_worker(request.worker);
  const std::size_t room = wire::kMaxLeasesPerWorker - std::min<std::size_t>(held, wire::kMaxLeasesPerWorker);
  const std::size_t wanted = std::min<std::size_t>({request.max_units, wire::kMaxLeasesPerCall, room});
  const auto granted = [&] { return batch.decision.leases.size(); };
  while (granted() < wanted && lease_pending(batch)) {
  }
  // Copies only for threads that would have nothing to do.
  while (granted() < wanted && held + granted() < batch.worker.info.threads && lease_copy(batch)) {
  }
  return std::move(batch.decision);
}

Scheduler::Job* Scheduler::choose_job(const Batch& batch) {
  Job* fair = nullptr;
  for (const auto& [negative_priority, job_leases, number] : turns_) {
    Job& job = *jobs_[number];
    const bool in_turn = fair == nullptr || (job.request.priority == fair->request.priority &&
                                             job_leases <= fair->leases + kAffinitySlack);
    if (!in_turn) break;
    if (job.units.pending() == 0 || !may_work_on(batch.worker, job)) continue;
    if (std::find(batch.nothing_for_it.begin(), batch.nothing_for_it.end(), &job) != batch.nothing_for_it.end())
      continue;
    const auto& scenes = batch.scenes;
    if (std::find(scenes.begin(), scenes.end(), job.request.scene_digest) != scenes.end()) return &job;
    if (fair == nullptr) fair = &job;
  }
  return fair;
}

bool Scheduler::lease_pending(Batch& batch) {
  while (Job* const job = choose_job(batch)) {
    const auto unit =
        job->units.take_pending([&](std::uint32_t candidate) { return !avoids(batch.worker, *job, candidate); });
    if (unit) {
      grant(batch, *job, *unit);
      return true;
    }
    batch.nothing_for_it.push_back(job);
  }
  return false;
}

bool Scheduler::lease_copy(Batch& batch) {
  for (const auto& [negative_priority, job_leases, number] : turns_) {
    Job& job = *jobs_[number];
    if (job.units.pending() > 0 || !may_work_on(batch.worker, job)) continue;
    const Time age = copy_age(job);
    for (const auto& [granted_at, id] : job.only_leases) {
      if (batch.now - granted_at < age) break;
      const Lease& lease = leases_.get(id);
      if (lease.worker == batch.worker.info.id || avoids(batch.worker, job, lease.unit)) continue;
      grant(batch, job, lease.unit);
      return true;
    }
  }
  return false;
}

/// A unit that is out for twice the usual time is likely to be on a slow or a dead worker.
Time Scheduler::copy_age(const Job& job) const {
  if (job.mean_duration == Time{0}) return options_.lease_timeout / 2;
  return std::max(options_.min_copy_age, 2 * job.mean_duration);
}

bool Scheduler::may_work_on(const Worker& worker, const Job& job) const {
  return job.request.isa.empty() ? worker.supports(worker.info.isa) : worker.supports(job.request.isa);
}

/// True when the unit failed on this worker and another worker could take it.
bool Scheduler::avoids(const Worker& worker, const Job& job, std::uint32_t unit) const {
  const auto failed = job.failures.find(unit);
  if (failed == job.failures.end()) return false;
  const auto failed_on = [&](const std::string& id) {
    const std::vector<std::string>& workers = failed->second.workers;
    return std::find(workers.begin(), workers.end(), id) != workers.end();
  };
  return failed_on(worker.info.id) && std::any_of(workers_.begin(), workers_.end(), [&](const auto& entry) {
           const Worker& other = entry.second;
           return !other.draining && !failed_on(entry.first) && may_work_on(other, job);
         });
}

void Scheduler::grant(Batch& batch, Job& job, std::uint32_t unit) {
  job.state = v1::RUNNING;
  if (job.request.isa.empty()) {
    job.request.isa = batch.worker.info.isa;
    batch.decision.bound_jobs.push_back(job.request.id);
  }
  Lease lease{.job = job.number,
              .unit = unit,
              .attempt = ++job.attempts,
              .epoch = options_.epoch,
              .worker = batch.worker.info.id,
              .granted_at = batch.now,
              .deadline = batch.now + options_.lease_timeout};
  v1::Lease& out = batch.decision.leases.emplace_back();
  v1::LeaseToken& token = *out.mutable_token();
  token.set_job_id(job.request.id);
  token.set_generation(job.request.generation);
  token.set_unit_index(unit);
  token.set_attempt(lease.attempt);
  token.set_epoch(lease.epoch);
  *out.mutable_unit() = job.request.plan->unit(unit);
  // The rest of the batch had better be of the same scene.
  if (std::find(batch.scenes.begin(), batch.scenes.end(), job.request.scene_digest) == batch.scenes.end()) {
    batch.scenes.push_back(job.request.scene_digest);
  }
  add_lease(job, std::move(lease));
}

// ---------------------------------------------------------------- keeping alive

absl::StatusOr<HeartbeatDecision> Scheduler::heartbeat(std::string_view worker_id,
                                                       const std::vector<v1::LeaseToken>& leases, Time now) {
  const absl::StatusOr<Worker*> worker = find_worker(worker_id, now);
  if (!worker.ok()) return worker.status();
  HeartbeatDecision decision{.revoked = {}, .drain = (*worker)->draining};
  for (const v1::LeaseToken& token : leases) {
    const absl::StatusOr<Job*> job = find_open_job(token);
    const std::optional<LeaseId> lease = job.ok() ? find_lease(**job, token, worker_id) : std::nullopt;
    if (lease) {
      leases_.refresh(*lease, now + options_.lease_timeout);
    } else if (!job.ok() || !take_up(**worker, **job, token, now)) {
      decision.revoked.push_back(token);
    }
  }
  return decision;
}

/// A lease that is not known any more goes on where it was, when nobody else has begun with its unit.
bool Scheduler::take_up(const Worker& worker, Job& job, const v1::LeaseToken& token, Time now) {
  const std::uint32_t unit = token.unit_index();
  if (job.request.isa.empty() || !worker.supports(job.request.isa)) return false;
  if (job.units.state(unit) != UnitState::kPending) return false;
  job.state = v1::RUNNING;
  job.units.take(unit);
  add_lease(job, {.job = job.number,
                  .unit = unit,
                  .attempt = token.attempt(),
                  .epoch = token.epoch(),
                  .worker = worker.info.id,
                  .granted_at = now,
                  .deadline = now + options_.lease_timeout});
  return true;
}

Expiry Scheduler::advance(Time now) {
  Expiry expiry;
  const std::size_t before = leases_.size();
  while (const std::optional<LeaseId> lease = leases_.expired(now)) drop_lease(*lease);
  for (const auto& [id, worker] : workers_) {
    if (now - worker.last_seen >= options_.lease_timeout) expiry.lost_workers.push_back(worker.info);
  }
  for (const WorkerInfo& lost : expiry.lost_workers) drop_worker(lost.id);
  expiry.lost_leases = static_cast<std::uint32_t>(before - leases_.size());
  return expiry;
}

// ---------------------------------------------------------------- bookkeeping

void Scheduler::add_lease(Job& job, Lease lease) {
  const std::vector<LeaseId> others = leases_.of_unit(job.number, lease.unit);
  for (const LeaseId other : others) job.only_leases.erase({leases_.get(other).granted_at, other});
  const Time granted_at = lease.granted_at;
  const LeaseId id = leases_.add(std::move(lease));
  if (others.empty()) job.only_leases.emplace(granted_at, id);
  set_leases(job, job.leases + 1);
}

void Scheduler::drop_lease(LeaseId id) {
  const Lease lease = leases_.remove(id);
  Job& job = *jobs_[lease.job];
  job.only_leases.erase({lease.granted_at, id});
  set_leases(job, job.leases - 1);
  const std::vector<LeaseId> others = leases_.of_unit(lease.job, lease.unit);
  if (others.size() == 1) job.only_leases.emplace(leases_.get(others.front()).granted_at, others.front());
  if (others.empty() && job.units.state(lease.unit) == UnitState::kLeased) job.units.put_back(lease.unit);
}

void Scheduler::set_leases(Job& job, std::uint32_t leases) {
  turns_.erase(turn(job));
  job.leases = leases;
  turns_.insert(turn(job));
}

}  // namespace tessera::server
