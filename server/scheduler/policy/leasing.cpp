#include "scheduler/policy/leasing.h"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "scheduler/spot.h"
#include "wire/limits.h"

namespace tessera::server {

struct Leasing::Batch {
  FarmWorker& worker;
  Time now;
  std::size_t held = 0;                        // leases before this batch
  std::vector<std::string> scenes;             // that the worker holds, or will hold after this batch
  std::vector<const FarmJob*> nothing_for_it;  // jobs whose pending units are not for this worker
  FarmJob* passed_over = nullptr;              // whose turn it was when another was chosen
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

LeaseDecision Leasing::lease(FarmWorker& worker, const LeaseRequest& request, Time now) {
  const std::size_t held = state_.leases.count_of_worker(request.worker);
  Batch batch{.worker = worker,
              .now = now,
              .held = held,
              .scenes = request.loaded_scenes,
              .nothing_for_it = {},
              .passed_over = nullptr,
              .decision = {},
              .left = {}};
  if (batch.worker.draining || !trust_.trusts(batch.worker.info.host)) return {};

  const std::size_t room = wire::kMaxLeasesPerWorker - std::min<std::size_t>(held, wire::kMaxLeasesPerWorker);
  const std::size_t wanted = std::min<std::size_t>({request.max_units, wire::kMaxLeasesPerCall, room});
  const auto granted = [&] { return batch.decision.leases.size(); };
  if (wanted == 0 || lease_dangerous(batch)) return std::move(batch.decision);
  // One a call: results that are wrong are worth knowing of early, but not in place of everything else.
  if (state_.auditing.empty() || !lease_audit(batch)) lease_spot(batch);
  while (granted() < wanted && lease_pending(batch)) {
  }
  // Copies only for threads that would have nothing to do.
  while (granted() < wanted && batch.in_hand() < batch.worker.info.threads && lease_copy(batch)) {
  }
  return std::move(batch.decision);
}

/// Whether the job has units for this worker, be its hands full or not.
bool Leasing::has_units_for(const Batch& batch, const FarmJob& job) const {
  if (job.units.pending() == 0 || !eligibility_.may_work_on(batch.worker, job, batch.now)) return false;
  const auto& useless = batch.nothing_for_it;
  if (std::find(useless.begin(), useless.end(), &job) != useless.end()) return false;
  if (checks_.withholds(batch.worker, job)) return false;
  return !would_come_late(batch, job);
}

/// The job whose turn it is; or one behind it whose scene the worker holds, within bounds.
FarmJob* Leasing::choose_job(Batch& batch) {
  std::optional<TurnOrder::Turn> fair;
  FarmJob* chosen = nullptr;
  const auto holds_scene = [&](const FarmJob& job) {
    return std::find(batch.scenes.begin(), batch.scenes.end(), job.request.scene_digest) !=
           batch.scenes.end();
  };
  const bool holds_any = std::any_of(batch.scenes.begin(), batch.scenes.end(), [&](const std::string& scene) {
    return state_.jobs_by_scene.contains(scene);
  });
  state_.turns.for_each([&](const TurnOrder::Turn& turn) {
    if (fair &&
        (turn.priority != fair->priority || turn.user_used_ms > fair->user_used_ms + kAffinitySlackMs)) {
      return TurnOrder::Next::kStop;
    }
    const bool in_order = state_.options.order == JobOrder::kFirstCome;
    if (fair && !in_order && turn.job_used_ms > fair->job_used_ms + kAffinitySlackMs)
      return TurnOrder::Next::kJob;
    FarmJob& job = *state_.jobs_by_number.at(turn.job);
    if (!has_units_for(batch, job)) return TurnOrder::Next::kJob;
    // Hands that are too full for a job are not for those behind it either.
    if (!has_room(batch, job)) return in_order ? TurnOrder::Next::kUser : TurnOrder::Next::kJob;
    if (holds_scene(job)) {
      chosen = &job;
      return TurnOrder::Next::kStop;
    }
    if (!fair) fair = turn;
    if (!holds_any || state_.jobs_by_number.at(fair->job)->passed_over_ms >= kAffinitySlackMs)
      return TurnOrder::Next::kStop;
    return in_order ? TurnOrder::Next::kUser : TurnOrder::Next::kJob;
  });
  batch.passed_over = chosen != nullptr && fair ? state_.jobs_by_number.at(fair->job).get() : nullptr;
  return chosen == nullptr && fair ? state_.jobs_by_number.at(fair->job).get() : chosen;
}

bool Leasing::lease_pending(Batch& batch) {
  while (FarmJob* const job = choose_job(batch)) {
    const auto unit = job->units.take_pending([&](std::uint32_t candidate) {
      return !job->dangerous.contains(candidate) && !eligibility_.avoids(batch.worker, *job, candidate);
    });
    if (unit) {
      const UnitRun units = runs_.run_from(batch.worker, *job, *unit);
      for (std::uint32_t i = 1; i < units.count; ++i) job->units.take(units[i]);
      if (batch.passed_over != nullptr) batch.passed_over->passed_over_ms += runs_.charge_for(*job, units);
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
bool Leasing::lease_dangerous(Batch& batch) {
  FarmWorker& worker = batch.worker;
  if (worker.isolated) return true;
  std::size_t waiting = 0;
  for (const std::uint64_t number : state_.endangered) {
    FarmJob& job = *state_.jobs_by_number.at(number);
    if (job.held() || !eligibility_.may_work_on(worker, job, batch.now)) continue;
    for (const std::uint32_t unit : job.dangerous) {
      if (job.units.state(unit) != UnitState::kPending || eligibility_.avoids(worker, job, unit)) continue;
      ++waiting;
      if (batch.held > 0) continue;
      job.units.take(unit);
      grant(batch, job, *job.request.plan->run(unit, 1), /*audit=*/false);
      worker.isolated = true;
      state_.freeing.erase(worker.info.id);
      return true;
    }
  }
  if (waiting == 0) {
    state_.freeing.erase(worker.info.id);
    return false;
  }
  // A busy worker asks for more before its hands are empty: as many as there are such units are kept waiting.
  if (state_.freeing.size() < waiting) state_.freeing.insert(worker.info.id);
  return state_.freeing.contains(worker.info.id);
}

bool Leasing::lease_audit(Batch& batch) {
  for (const std::uint64_t number : state_.auditing) {
    FarmJob& job = *state_.jobs_by_number.at(number);
    if (job.held()) continue;
    for (const std::uint32_t unit : job.audits.waiting()) {
      if (!audits_.can_make(batch.worker, job, *job.audits.find(unit))) continue;
      if (job.audited.insert(unit).second) {
        FarmEvent& event = state_.record(FarmEvent::Kind::kAudit, job.request.id);
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

bool Leasing::lease_spot(Batch& batch) {
  for (const std::uint64_t number : state_.checking) {
    FarmJob& job = *state_.jobs_by_number.at(number);
    if (job.held()) continue;
    for (const std::uint32_t unit : job.spots.waiting()) {
      const SpotCheck& check = *job.spots.find(unit);
      if (!checks_.can_make(batch.worker, job, check)) continue;
      grant(batch, job, job.units.result(unit).units, /*audit=*/true, check.spot);
      job.spots.take(unit, batch.now);
      return true;
    }
  }
  return false;
}

bool Leasing::lease_copy(Batch& batch) {
  FarmJob* job = nullptr;
  UnitRun units;
  state_.turns.for_each([&](const TurnOrder::Turn& turn) {
    FarmJob& candidate = *state_.jobs_by_number.at(turn.job);
    if (candidate.units.pending() > candidate.dangerous.size() ||
        !eligibility_.may_work_on(batch.worker, candidate, batch.now) ||
        checks_.withholds(batch.worker, candidate)) {
      return TurnOrder::Next::kJob;
    }
    const auto suits = [&](LeaseId id) {
      const Lease& lease = state_.leases.get(id);
      // A run that was lost with another worker is not copied but cut, once nobody has it any more.
      const bool killer =
          candidate.dangerous.contains(lease.units.first) ||
          (lease.units.count > 1 && !runs_.fits_run(candidate, lease.units.first, lease.units.count));
      return lease.worker != batch.worker.info.id && !killer &&
             !eligibility_.avoids(batch.worker, candidate, lease.units.first);
    };
    const auto choose = [&](LeaseId id) {
      job = &candidate;
      units = state_.leases.get(id).units;
      return TurnOrder::Next::kStop;
    };
    // Units on a worker that is known to be so slow that a copy would be there in less than half the time.
    for (auto last = candidate.by_end.rbegin(); last != candidate.by_end.rend(); ++last) {
      const double left_ms = static_cast<double>((last->first - batch.now).count());
      if (left_ms <= 2 * candidate.mean_unit_cost_ms * batch.worker.slowness) break;
      const Time own = runs_.expected_cost(batch.worker, candidate, state_.leases.get(last->second).units);
      if (last->first - batch.now > 2 * own && suits(last->second)) return choose(last->second);
    }
    // A unit that is out for twice the usual time, and for twice the time that was expected of it, is likely
    // to be on a dead worker, or on one that became slow.
    const Time age = candidate.mean_lease_duration == Time{0}
                         ? state_.options.lease_timeout / 2
                         : std::max(state_.options.min_copy_age, 2 * candidate.mean_lease_duration);
    for (const auto& [granted_at, id] : candidate.only_leases) {
      if (batch.now - granted_at < age) break;
      const bool in_time = batch.now - granted_at < 2 * (state_.leases.get(id).expected_end - granted_at);
      if (!in_time && suits(id)) return choose(id);
    }
    return TurnOrder::Next::kJob;
  });
  if (job == nullptr) return false;
  grant(batch, *job, units, /*audit=*/false);
  return true;
}

/// Whether one more unit of this job fits into the worker's hands. Every thread has one; beyond that, until
/// SchedulerOptions::batch is in hand, and no more than half of what would be the worker's part of all that
/// is left: so batches shrink towards the end [Polychronopoulos1987]. What the unit itself costs does not
/// count, or jobs of units that just fit would get whatever is given out ahead, whoever's turn it is.
bool Leasing::has_room(const Batch& batch, const FarmJob& job) const {
  const FarmWorker& worker = batch.worker;
  const std::uint64_t threads = worker.info.threads;
  if (job.mean_unit_cost_ms == 0 || batch.in_hand() < threads) return true;
  const auto in_hand_ms = static_cast<std::int64_t>(static_cast<double>(worker.load_ms) * worker.slowness);
  if (Time(in_hand_ms) >= state_.options.batch * static_cast<std::int64_t>(threads)) return false;
  // Units in hand beyond one lease a thread.
  const std::uint64_t ahead = worker.leased_units - worker.leased_units * threads / batch.in_hand() + 1;
  return is_left(batch, job.request.priority, (2 * state_.total_threads * ahead + threads - 1) / threads);
}

/// Whether so many units are pending in jobs of at least this priority that the worker may take.
bool Leasing::is_left(const Batch& batch, std::int32_t priority, std::uint64_t wanted) const {
  std::optional<Batch::Left>& left = batch.left;
  if (!left || left->priority != priority || (left->units < wanted && !left->all)) {
    left = {.priority = priority, .units = 0, .all = true};
    state_.turns.for_each([&](const TurnOrder::Turn& turn) {
      if (turn.priority < priority) return TurnOrder::Next::kStop;
      const FarmJob& job = *state_.jobs_by_number.at(turn.job);
      if (job.units.pending() > 0 && eligibility_.may_work_on(batch.worker, job, batch.now))
        left->units += job.units.pending();
      left->all = left->units < 2 * wanted;  // the next unit wants more
      return left->all ? TurnOrder::Next::kJob : TurnOrder::Next::kStop;
    });
  }
  return left->units >= wanted;
}

/// Whether the others will have done all that is left well before this slow worker would have done one unit.
bool Leasing::would_come_late(const Batch& batch, const FarmJob& job) const {
  if (job.mean_unit_cost_ms == 0 || batch.worker.slowness < 2) return false;
  double at_work = 0;  // threads of others, each by its pace
  for (const auto& [id, leases] : job.holders) {
    if (id == batch.worker.info.id) continue;
    const FarmWorker& other = state_.workers.at(id);
    at_work += std::min(leases, other.counted_threads) / other.slowness;
  }
  // Both in what a usual worker takes for a unit; nobody else at work, and there is no end to wait for.
  return at_work > 0 && batch.worker.slowness > 2 * (1 + job.units.pending() / at_work);
}

void Leasing::grant(Batch& batch, FarmJob& job, const UnitRun& units, bool audit, const Spot& spot) {
  FarmWorker& worker = batch.worker;
  if (batch.left && batch.left->priority <= job.request.priority) {
    batch.left->units -= std::min<std::uint64_t>(batch.left->units, units.count);
  }
  job.state = v1::RUNNING;
  job.passed_over_ms = 0;
  classes_.bind(job, *classes_.class_for(worker, job));
  const Time cost = runs_.expected_cost(worker, job, units);
  const std::int64_t ahead =
      static_cast<std::int64_t>(static_cast<double>(worker.load_ms) * worker.slowness) / worker.info.threads;
  Lease lease{.job = job.number,
              .units = units,
              .attempt = ++job.attempts,
              .epoch = state_.options.epoch,
              .worker = worker.info.id,
              .granted_at = batch.now,
              .deadline = batch.now + book_.lease_time(),
              .audit = audit,
              .spot = spot.number,
              .work_share = spot.number == 0 ? 1 : spot.share,
              .expected_end = job.mean_unit_cost_ms == 0 ? Time{0} : batch.now + Time(ahead) + cost};
  v1::Lease& out = batch.decision.leases.emplace_back();
  v1::LeaseToken& token = *out.mutable_token();
  token.set_job_id(job.request.id);
  token.set_generation(job.request.generation);
  token.set_unit_index(units.first);
  if (units.count > 1) token.set_ranges(units.count);
  token.set_inputs(Steps::inputs_of(job, units.first).value_or(0));
  token.set_attempt(lease.attempt);
  token.set_epoch(lease.epoch);
  *out.mutable_unit() = job.request.plan->unit(units);
  if (spot.number != 0) {
    token.set_spot(spot.number);
    v1::PixelRect& pixels = *out.mutable_unit()->mutable_tile()->mutable_pixels();
    pixels = spot_pixels(pixels, spot.number);
  }
  // The rest of the batch had better be of the same scene.
  if (std::find(batch.scenes.begin(), batch.scenes.end(), job.request.scene_digest) == batch.scenes.end()) {
    batch.scenes.push_back(job.request.scene_digest);
  }
  book_.add(job, worker, std::move(lease));
}

bool Leasing::take_up(FarmWorker& worker, FarmJob& job, const UnitRun& units, const v1::LeaseToken& token,
                      Time now) {
  // Where no class is bound, no unit was given out.
  if (!job.request.any_class && job.classes.bound().empty()) return false;
  if (classes_.class_for(worker, job) == nullptr || !trust_.trusts(worker.info.host)) return false;
  for (const std::uint32_t unit : units) {
    if (unit >= job.units.open_end() || job.units.state(unit) != UnitState::kPending ||
        job.dangerous.contains(unit)) {
      return false;
    }
  }
  job.state = v1::RUNNING;
  for (const std::uint32_t unit : units) job.units.take(unit);
  book_.add(job, worker,
            {.job = job.number,
             .units = units,
             .attempt = token.attempt(),
             .epoch = token.epoch(),
             .worker = worker.info.id,
             .granted_at = now,
             .deadline = now + book_.lease_time()});
  return true;
}

}  // namespace tessera::server
