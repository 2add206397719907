// Who gets which unit, for how long.
#include <algorithm>

#include "scheduler/identity.h"
#include "scheduler/scheduler.h"
#include "wire/limits.h"

namespace tessera::server {

struct Scheduler::Batch {
  Worker& worker;
  Time now;
  std::size_t held = 0;                    // leases before this batch
  std::vector<std::string> scenes;         // that the worker holds, or will hold after this batch
  std::vector<const Job*> nothing_for_it;  // jobs whose pending units are not for this worker
  Job* passed_over = nullptr;              // whose turn it was when another was chosen
  LeaseDecision decision;

  /// Pending units that this worker may take, of jobs of at least this priority: all, or as many as were
  /// looked for.
  struct Left {
    std::int32_t priority = 0;
    std::uint64_t units = 0;
    bool all = false;
  };
  mutable std::optional<Left> left;

  std::size_t in_hand() const { return held + decision.leases.size(); }
};

// ---------------------------------------------------------------- granting

absl::StatusOr<LeaseDecision> Scheduler::lease(const LeaseRequest& request, Time now) {
  const absl::StatusOr<Worker*> worker = find_worker(request.worker, now);
  if (!worker.ok()) return worker.status();
  turns_.advance(now);
  const std::size_t held = leases_.count_of_worker(request.worker);
  Batch batch{.worker = **worker,
              .now = now,
              .held = held,
              .scenes = request.loaded_scenes,
              .nothing_for_it = {},
              .passed_over = nullptr,
              .decision = {},
              .left = {}};
  if (batch.worker.draining || !trusts(batch.worker.info.host)) return LeaseDecision{};

  const std::size_t room = wire::kMaxLeasesPerWorker - std::min<std::size_t>(held, wire::kMaxLeasesPerWorker);
  const std::size_t wanted = std::min<std::size_t>({request.max_units, wire::kMaxLeasesPerCall, room});
  const auto granted = [&] { return batch.decision.leases.size(); };
  if (wanted == 0 || lease_dangerous(batch)) return std::move(batch.decision);
  // One a call: results that are wrong are worth knowing of early, but not in place of everything else.
  if (!auditing_.empty()) lease_audit(batch);
  while (granted() < wanted && lease_pending(batch)) {
  }
  // Copies only for threads that would have nothing to do.
  while (granted() < wanted && batch.in_hand() < batch.worker.info.threads && lease_copy(batch)) {
  }
  return std::move(batch.decision);
}

/// Whether the job has units for this worker, be its hands full or not.
bool Scheduler::has_units_for(const Batch& batch, const Job& job) const {
  if (job.units.pending() == 0 || !may_work_on(batch.worker, job, batch.now)) return false;
  const auto& useless = batch.nothing_for_it;
  if (std::find(useless.begin(), useless.end(), &job) != useless.end()) return false;
  return !would_come_late(batch, job);
}

/// The job whose turn it is; or one behind it whose scene the worker holds, within bounds.
Scheduler::Job* Scheduler::choose_job(Batch& batch) {
  std::optional<TurnOrder::Turn> fair;
  Job* chosen = nullptr;
  const auto holds_scene = [&](const Job& job) {
    return std::find(batch.scenes.begin(), batch.scenes.end(), job.request.scene_digest) !=
           batch.scenes.end();
  };
  const bool holds_any = std::any_of(batch.scenes.begin(), batch.scenes.end(), [&](const std::string& scene) {
    return jobs_by_scene_.contains(scene);
  });
  turns_.for_each([&](const TurnOrder::Turn& turn) {
    if (fair &&
        (turn.priority != fair->priority || turn.user_used_ms > fair->user_used_ms + kAffinitySlackMs)) {
      return TurnOrder::Next::kStop;
    }
    const bool in_order = options_.order == JobOrder::kFirstCome;
    if (fair && !in_order && turn.job_used_ms > fair->job_used_ms + kAffinitySlackMs)
      return TurnOrder::Next::kJob;
    Job& job = *jobs_.at(turn.job);
    if (!has_units_for(batch, job)) return TurnOrder::Next::kJob;
    // Hands that are too full for a job are not for those behind it either.
    if (!has_room(batch, job)) return in_order ? TurnOrder::Next::kUser : TurnOrder::Next::kJob;
    if (holds_scene(job)) {
      chosen = &job;
      return TurnOrder::Next::kStop;
    }
    if (!fair) fair = turn;
    if (!holds_any || jobs_.at(fair->job)->passed_over_ms >= kAffinitySlackMs) return TurnOrder::Next::kStop;
    return in_order ? TurnOrder::Next::kUser : TurnOrder::Next::kJob;
  });
  batch.passed_over = chosen != nullptr && fair ? jobs_.at(fair->job).get() : nullptr;
  return chosen == nullptr && fair ? jobs_.at(fair->job).get() : chosen;
}

bool Scheduler::lease_pending(Batch& batch) {
  while (Job* const job = choose_job(batch)) {
    const auto unit = job->units.take_pending([&](std::uint32_t candidate) {
      return !job->dangerous.contains(candidate) && !avoids(batch.worker, *job, candidate);
    });
    if (unit) {
      const UnitRun units = run_from(batch.worker, *job, *unit);
      for (std::uint32_t i = 1; i < units.count; ++i) job->units.take(units[i]);
      if (batch.passed_over != nullptr) batch.passed_over->passed_over_ms += charge_for(*job, units);
      grant(batch, *job, units, /*audit=*/false);
      return true;
    }
    batch.nothing_for_it.push_back(job);
  }
  return false;
}

/// A unit that was lost with several workers may be what killed them. It goes to a worker that holds nothing
/// else, so that nothing else suffers, and its next loss speaks for itself. True when this call is settled by
/// that.
bool Scheduler::lease_dangerous(Batch& batch) {
  Worker& worker = batch.worker;
  if (worker.isolated) return true;
  std::size_t waiting = 0;
  for (const std::uint64_t number : endangered_) {
    Job& job = *jobs_.at(number);
    if (job.paused || !may_work_on(worker, job, batch.now)) continue;
    for (const std::uint32_t unit : job.dangerous) {
      if (job.units.state(unit) != UnitState::kPending || avoids(worker, job, unit)) continue;
      ++waiting;
      if (batch.held > 0) continue;
      job.units.take(unit);
      grant(batch, job, *job.request.plan->run(unit, 1), /*audit=*/false);
      worker.isolated = true;
      freeing_.erase(worker.info.id);
      return true;
    }
  }
  if (waiting == 0) {
    freeing_.erase(worker.info.id);
    return false;
  }
  // A busy worker asks for more before its hands are empty: as many as there are such units are kept waiting.
  if (freeing_.size() < waiting) freeing_.insert(worker.info.id);
  return freeing_.contains(worker.info.id);
}

bool Scheduler::lease_audit(Batch& batch) {
  for (const std::uint64_t number : auditing_) {
    Job& job = *jobs_.at(number);
    if (job.paused) continue;
    for (const std::uint32_t unit : job.audits.waiting()) {
      if (!can_audit(batch.worker, job, *job.audits.find(unit))) continue;
      if (job.audited.insert(unit).second) {
        FarmEvent& event = record(FarmEvent::Kind::kAudit, job.request.id);
        event.unit = unit;
        event.value = job.units.result(unit).sequence;
        event.host = batch.worker.info.host;
      }
      grant(batch, job, job.units.result(unit).units, /*audit=*/true);
      job.audits.take(unit);
      return true;
    }
  }
  return false;
}

bool Scheduler::lease_copy(Batch& batch) {
  Job* job = nullptr;
  UnitRun units;
  turns_.for_each([&](const TurnOrder::Turn& turn) {
    Job& candidate = *jobs_.at(turn.job);
    if (candidate.units.pending() > candidate.dangerous.size() ||
        !may_work_on(batch.worker, candidate, batch.now)) {
      return TurnOrder::Next::kJob;
    }
    const auto suits = [&](LeaseId id) {
      const Lease& lease = leases_.get(id);
      // A run that was lost with another worker is not copied but cut, once nobody has it any more.
      const bool killer =
          candidate.dangerous.contains(lease.units.first) ||
          (lease.units.count > 1 && !fits_run(candidate, lease.units.first, lease.units.count));
      return lease.worker != batch.worker.info.id && !killer &&
             !avoids(batch.worker, candidate, lease.units.first);
    };
    const auto choose = [&](LeaseId id) {
      job = &candidate;
      units = leases_.get(id).units;
      return TurnOrder::Next::kStop;
    };
    // Units on a worker that is known to be so slow that a copy would be there in less than half the time.
    for (auto last = candidate.by_end.rbegin(); last != candidate.by_end.rend(); ++last) {
      const double left_ms = static_cast<double>((last->first - batch.now).count());
      if (left_ms <= 2 * candidate.mean_cost_ms * batch.worker.slowness) break;
      const Time own = expected_cost(batch.worker, candidate, leases_.get(last->second).units);
      if (last->first - batch.now > 2 * own && suits(last->second)) return choose(last->second);
    }
    // A unit that is out for twice the usual time, and for twice the time that was expected of it, is likely
    // to be on a dead worker, or on one that became slow.
    const Time age = candidate.mean_duration == Time{0}
                         ? options_.lease_timeout / 2
                         : std::max(options_.min_copy_age, 2 * candidate.mean_duration);
    for (const auto& [granted_at, id] : candidate.only_leases) {
      if (batch.now - granted_at < age) break;
      const bool in_time = batch.now - granted_at < 2 * (leases_.get(id).expected_end - granted_at);
      if (!in_time && suits(id)) return choose(id);
    }
    return TurnOrder::Next::kJob;
  });
  if (job == nullptr) return false;
  grant(batch, *job, units, /*audit=*/false);
  return true;
}

// ---------------------------------------------------------------- who may have what

/// Whether one more unit of this job fits into the worker's hands. Every thread has one; beyond that, until
/// SchedulerOptions::batch is in hand, and no more than half of what would be the worker's part of all that
/// is left: so batches shrink towards the end [Polychronopoulos1987]. What the unit itself costs does not
/// count, or jobs of units that just fit would get whatever is given out ahead, whoever's turn it is.
bool Scheduler::has_room(const Batch& batch, const Job& job) const {
  const Worker& worker = batch.worker;
  const std::uint64_t threads = worker.info.threads;
  if (job.mean_cost_ms == 0 || batch.in_hand() < threads) return true;
  const auto in_hand_ms = static_cast<std::int64_t>(static_cast<double>(worker.load_ms) * worker.slowness);
  if (Time(in_hand_ms) >= options_.batch * static_cast<std::int64_t>(threads)) return false;
  // Units in hand beyond one lease a thread.
  const std::uint64_t ahead = worker.units - worker.units * threads / batch.in_hand() + 1;
  return is_left(batch, job.request.priority, (2 * threads_ * ahead + threads - 1) / threads);
}

/// Whether so many units are pending in jobs of at least this priority that the worker may take.
bool Scheduler::is_left(const Batch& batch, std::int32_t priority, std::uint64_t wanted) const {
  std::optional<Batch::Left>& left = batch.left;
  if (!left || left->priority != priority || (left->units < wanted && !left->all)) {
    left = {.priority = priority, .units = 0, .all = true};
    turns_.for_each([&](const TurnOrder::Turn& turn) {
      if (turn.priority < priority) return TurnOrder::Next::kStop;
      const Job& job = *jobs_.at(turn.job);
      if (job.units.pending() > 0 && may_work_on(batch.worker, job, batch.now))
        left->units += job.units.pending();
      left->all = left->units < 2 * wanted;  // the next unit wants more
      return left->all ? TurnOrder::Next::kJob : TurnOrder::Next::kStop;
    });
  }
  return left->units >= wanted;
}

/// Whether the others will have done all that is left well before this slow worker would have done one unit.
bool Scheduler::would_come_late(const Batch& batch, const Job& job) const {
  if (job.mean_cost_ms == 0 || batch.worker.slowness < 2) return false;
  double at_work = 0;  // threads of others, each by its pace
  for (const auto& [id, leases] : job.holders) {
    if (id == batch.worker.info.id) continue;
    const Worker& other = workers_.at(id);
    at_work += std::min(leases, other.info.threads) / other.slowness;
  }
  // Both in what a usual worker takes for a unit; nobody else at work, and there is no end to wait for.
  return at_work > 0 && batch.worker.slowness > 2 * (1 + job.units.pending() / at_work);
}

bool Scheduler::may_work_on(const Worker& worker, const Job& job, Time now) const {
  if (worker.draining || !trusts(worker.info.host)) return false;
  if (class_for(worker, job) == nullptr || settling(job, now)) return false;
  if (!has_tags(worker.info, job.request.required_tags)) return false;
  if (const auto host = job.hosts.find(worker.info.host);
      host != job.hosts.end() && now < host->second.barred_until) {
    return false;
  }
  const std::uint32_t most = job.request.max_workers;
  return most == 0 || job.holders.size() < most || job.holders.contains(worker.info.id);
}

/// True when the unit failed on this host and another host could take it, or too often on this identity and
/// another one could.
bool Scheduler::avoids(const Worker& worker, const Job& job, std::uint32_t unit) const {
  const auto failed = job.failures.find(unit);
  if (failed == job.failures.end()) return false;
  if (awaits_another(job, failed->second) &&
      identity_of(failed->second.front().host) == identity_of(worker.info.host)) {
    return true;
  }
  const auto failed_on = [&](const std::string& host) {
    return std::any_of(failed->second.begin(), failed->second.end(),
                       [&](const UnitFailure& failure) { return failure.host == host; });
  };
  return failed_on(worker.info.host) && std::any_of(workers_.begin(), workers_.end(), [&](const auto& entry) {
           const Worker& other = entry.second;
           return !failed_on(other.info.host) && may_work_on(other, job, other.last_seen);
         });
}

void Scheduler::grant(Batch& batch, Job& job, const UnitRun& units, bool audit) {
  Worker& worker = batch.worker;
  if (batch.left && batch.left->priority <= job.request.priority) {
    batch.left->units -= std::min<std::uint64_t>(batch.left->units, units.count);
  }
  job.state = v1::RUNNING;
  job.passed_over_ms = 0;
  bind(job, *class_for(worker, job));
  const Time cost = expected_cost(worker, job, units);
  const std::int64_t ahead =
      static_cast<std::int64_t>(static_cast<double>(worker.load_ms) * worker.slowness) / worker.info.threads;
  Lease lease{.job = job.number,
              .units = units,
              .attempt = ++job.attempts,
              .epoch = options_.epoch,
              .worker = worker.info.id,
              .granted_at = batch.now,
              .deadline = batch.now + lease_time(),
              .audit = audit,
              .expected_end = job.mean_cost_ms == 0 ? Time{0} : batch.now + Time(ahead) + cost};
  v1::Lease& out = batch.decision.leases.emplace_back();
  v1::LeaseToken& token = *out.mutable_token();
  token.set_job_id(job.request.id);
  token.set_generation(job.request.generation);
  token.set_unit_index(units.first);
  if (units.count > 1) token.set_ranges(units.count);
  token.set_inputs(inputs_of(job, units.first).value_or(0));
  token.set_attempt(lease.attempt);
  token.set_epoch(lease.epoch);
  *out.mutable_unit() = job.request.plan->unit(units);
  // The rest of the batch had better be of the same scene.
  if (std::find(batch.scenes.begin(), batch.scenes.end(), job.request.scene_digest) == batch.scenes.end()) {
    batch.scenes.push_back(job.request.scene_digest);
  }
  add_lease(job, worker, std::move(lease));
}

// ---------------------------------------------------------------- keeping alive

Time Scheduler::heartbeat_interval() const {
  const Time bearable{static_cast<std::int64_t>(workers_.size() * 1000 / kHeartbeatsPerSecond)};
  return std::clamp(bearable, options_.heartbeat_interval,
                    std::max(options_.heartbeat_interval, kLongestHeartbeat));
}

/// Two beats within it, one of which may be lost, are the least.
Time Scheduler::lease_time() const { return std::max(options_.lease_timeout, 5 * heartbeat_interval() / 2); }

absl::StatusOr<HeartbeatDecision> Scheduler::heartbeat(std::string_view worker_id,
                                                       const std::vector<v1::LeaseToken>& leases, Time now) {
  const absl::StatusOr<Worker*> worker = find_worker(worker_id, now);
  if (!worker.ok()) return worker.status();
  HeartbeatDecision decision{.revoked = {}, .drain = (*worker)->draining};
  for (const v1::LeaseToken& token : leases) {
    const absl::StatusOr<Job*> job = find_open_job(token);
    if (job.ok()) absolve(**job, token, (*worker)->info.host);
    const std::optional<UnitRun> units = job.ok() ? units_of(**job, token) : std::nullopt;
    const bool current = units && check_inputs(**job, token).ok();
    const std::optional<LeaseId> lease = current ? find_own_lease(**job, *units, worker_id) : std::nullopt;
    if (lease) {
      leases_.refresh(*lease, now + lease_time());
    } else if (!current || !take_up(**worker, **job, *units, token, now)) {
      decision.revoked.push_back(token);
    }
  }
  return decision;
}

/// The worker's lease of these units, whichever grant it names: after a restart a unit may be granted anew to
/// the worker that has it in its hands, and the answer that says so may still be on its way.
std::optional<LeaseId> Scheduler::find_own_lease(const Job& job, const UnitRun& units,
                                                 std::string_view worker) const {
  for (const LeaseId id : leases_.of_unit(job.number, units.first)) {
    if (leases_.get(id).worker == worker && leases_.get(id).units == units) return id;
  }
  return std::nullopt;
}

/// A lease that is not known any more goes on where it was, when nobody else has begun with its units.
bool Scheduler::take_up(Worker& worker, Job& job, const UnitRun& units, const v1::LeaseToken& token,
                        Time now) {
  // Where no class is bound, no unit was given out.
  if (!job.request.any_class && job.classes.bound().empty()) return false;
  if (class_for(worker, job) == nullptr || !trusts(worker.info.host)) return false;
  for (const std::uint32_t unit : units) {
    if (unit >= job.units.open_end() || job.units.state(unit) != UnitState::kPending ||
        job.dangerous.contains(unit)) {
      return false;
    }
  }
  job.state = v1::RUNNING;
  for (const std::uint32_t unit : units) job.units.take(unit);
  add_lease(job, worker,
            {.job = job.number,
             .units = units,
             .attempt = token.attempt(),
             .epoch = token.epoch(),
             .worker = worker.info.id,
             .granted_at = now,
             .deadline = now + lease_time()});
  return true;
}

Expiry Scheduler::advance(Time now) {
  turns_.advance(now);
  Expiry expiry;
  const std::size_t before = leases_.size();
  const Time patience = lease_time();
  for (const auto& [id, worker] : workers_) {
    if (now - worker.last_seen >= patience) expiry.lost_workers.push_back(worker.info);
  }
  // The same order in every run.
  std::sort(expiry.lost_workers.begin(), expiry.lost_workers.end(),
            [](const WorkerInfo& a, const WorkerInfo& b) { return a.id < b.id; });
  blame_loss(expiry.lost_workers, now);
  for (const WorkerInfo& lost : expiry.lost_workers) drop_worker(lost.id);
  while (const std::optional<LeaseId> lease = leases_.expired(now)) drop_lease(*lease);
  expiry.lost_leases = static_cast<std::uint32_t>(before - leases_.size());
  // Those who could have given second opinions may be gone.
  const std::set<std::uint64_t> auditing = auditing_;
  for (const std::uint64_t number : auditing) {
    Job& job = *jobs_.at(number);
    job.audits.erase_if([](std::uint32_t, const Audit& audit) { return audit.is_over(); });
    settle(job);
    if (job.audits.empty()) auditing_.erase(number);
  }
  return expiry;
}

// ---------------------------------------------------------------- bookkeeping

/// Takes the one lease of units into or out of the indices by which copies are chosen; none when there are
/// more.
void Scheduler::index_only_lease(Job& job, const UnitRun& units, bool add) {
  const std::vector<LeaseId> leases = leases_.of_unit(job.number, units.first);
  if (leases.size() != 1) return;
  const Lease& lease = leases_.get(leases.front());
  const std::pair by_age{lease.granted_at, leases.front()}, by_end{lease.expected_end, leases.front()};
  if (add) {
    job.only_leases.insert(by_age);
    if (lease.expected_end > Time{0}) job.by_end.insert(by_end);
  } else {
    job.only_leases.erase(by_age);
    job.by_end.erase(by_end);
  }
}

void Scheduler::add_lease(Job& job, Worker& worker, Lease lease) {
  const UnitRun units = lease.units;
  lease.charge_ms = charge_for(job, units);
  worker.load_ms += lease.charge_ms;
  worker.units += units.count;
  job.load_ms += lease.charge_ms;
  turns_.charge(job.number, lease.charge_ms);
  ++job.leases;
  ++job.holders[worker.info.id];
  const bool audit = lease.audit;
  if (!audit) index_only_lease(job, units, /*add=*/false);
  leases_.add(std::move(lease));
  if (!audit) index_only_lease(job, units, /*add=*/true);
}

void Scheduler::drop_lease(LeaseId id) {
  const Lease lease = leases_.get(id);
  Job& job = *jobs_.at(lease.job);
  if (!lease.audit) index_only_lease(job, lease.units, /*add=*/false);
  leases_.remove(id);

  Worker& worker = workers_.at(lease.worker);
  worker.load_ms -= lease.charge_ms;
  worker.units -= lease.units.count;
  if (leases_.count_of_worker(lease.worker) == 0) worker.isolated = false;
  job.load_ms -= lease.charge_ms;
  turns_.charge(job.number, -lease.charge_ms);
  --job.leases;
  if (const auto holder = job.holders.find(lease.worker); --holder->second == 0) job.holders.erase(holder);
  if (lease.audit) return job.audits.give_back(lease.units.first);
  if (!leases_.of_unit(job.number, lease.units.first).empty()) {
    return index_only_lease(job, lease.units, /*add=*/true);
  }
  for (const std::uint32_t unit : lease.units) {
    if (job.units.state(unit) == UnitState::kLeased) job.units.put_back(unit);
  }
}

}  // namespace tessera::server
