// The workers of the simulated farm.
#include <algorithm>
#include <cmath>
#include <random>

#include "absl/strings/str_cat.h"
#include "scenario/simulation.h"
#include "wire/arithmetic_class.h"

namespace tessera::server {
namespace {

constexpr Time kWorkerTick{2000};

bool same(const v1::LeaseToken& a, const v1::LeaseToken& b) {
  return covered_by(a) == covered_by(b) && a.attempt() == b.attempt() && a.epoch() == b.epoch() &&
         a.job_id() == b.job_id() && a.inputs() == b.inputs();
}

}  // namespace

ResultFingerprint Simulation::truth_of(const Promise& promise, const CoveredUnits& units,
                                       const std::string& arithmetic_class, std::uint64_t inputs) const {
  return inputs +
         (std::hash<std::string>{}(promise.content) * 31 + std::hash<std::string>{}(arithmetic_class)) * 31 +
         units.first + 10'007 * units.ranges;
}

std::string Simulation::class_of(const Worker& worker, const std::string& isa) {
  const auto found = std::find_if(worker.classes.begin(), worker.classes.end(),
                                  [&](const std::string& name) { return wire::isa_of(name) == isa; });
  return found == worker.classes.end() ? "" : *found;
}

UnitRun Simulation::units_of(const std::string& job, const CoveredUnits& covered) const {
  return *promises_.at(job).request.plan->run(covered.first, covered.ranges);
}

Simulation::Effort Simulation::effort_of(const v1::LeaseToken& token) const {
  std::mt19937_64 random(truth_of(promises_.at(token.job_id()), covered_by(token), "", 0));
  const double milliseconds = covered_by(token).ranges * std::lognormal_distribution<double>(
                                                             std::log(800.0), std::log(100.0) / 4)(random);
  const double rays_per_ms = std::lognormal_distribution<double>(std::log(1000.0), 0.3)(random);
  return {.milliseconds = milliseconds, .rays = 1 + static_cast<std::uint64_t>(milliseconds * rays_per_ms)};
}

void Simulation::start_worker(std::size_t index) {
  Worker& worker = workers_[index];
  worker.alive = true;
  ++worker.life;
  at(Time(pick(500)), [this, index, life = worker.life] {
    if (workers_[index].life == life) work(index);
  });
}

void Simulation::kill_worker(std::size_t index) {
  ++counts_.worker_deaths;
  Worker& worker = workers_[index];
  worker.alive = false;
  worker.id.clear();
  worker.held.clear();
  ++worker.life;
  at(Time(500 + pick(15'000)), [this, index] {
    if (!workers_[index].alive) start_worker(index);
  });
}

/// Does what a worker does again and again: heartbeats, new units, results that were not acknowledged.
void Simulation::work(std::size_t index) {
  Worker& worker = workers_[index];
  if (!worker.alive) return;
  at(kWorkerTick, [this, index, life = worker.life] {
    if (workers_[index].life == life) work(index);
  });
  if (chaos_ && chance(worker_death_)) return kill_worker(index);
  if (chaos_ && chance(0.01)) worker.hangs_until = now_ + Time(pick(60'000));
  if (now_ < worker.hangs_until) return;
  if (worker.id.empty()) return register_worker(index);

  std::vector<v1::LeaseToken> tokens;
  for (const Held& held : worker.held) tokens.push_back(held.token);
  to_coordinator([this, index, id = worker.id, tokens] {
    const absl::StatusOr<HeartbeatDecision> decision = coordinator_->heartbeat(id, tokens, now_);
    if (decision.ok()) trace_.add(*decision);
    to_worker(index, [this, index, id, decision] {
      Worker& told = workers_[index];
      if (absl::IsNotFound(decision.status()) && told.id == id) told.id.clear();
      if (!decision.ok()) return;
      for (const v1::LeaseToken& revoked : decision->revoked) {
        if (!chaos_ || pick(2) == 0) forget(told, revoked);  // others are delivered all the same, late
      }
    });
  });
  for (const Held& held : worker.held) {
    if (held.sent) deliver(index, held);
  }
  ask_for_units(index);
}

void Simulation::register_worker(std::size_t index) {
  const std::string id = absl::StrCat("w", ++names_);
  to_coordinator([this, index, id] {
    const Worker& there = workers_[index];
    std::vector<std::string> isas;
    for (const std::string& name : there.classes) isas.emplace_back(wire::isa_of(name));
    const absl::Status status = coordinator_->scheduler().register_worker({.id = id,
                                                                           .name = there.host,
                                                                           .build = "",
                                                                           .isa = isas.front(),
                                                                           .supported_isas = isas,
                                                                           .threads = there.threads,
                                                                           .host = there.host,
                                                                           .tags = {},
                                                                           .classes = there.classes},
                                                                          now_);
    if (!status.ok()) return;  // it came twice
    to_worker(index, [this, index, id] { workers_[index].id = id; });
  });
}

void Simulation::ask_for_units(std::size_t index) {
  Worker& worker = workers_[index];
  if (worker.held.size() >= 2 * worker.threads) return;
  const auto wanted = static_cast<std::uint32_t>(2 * worker.threads - worker.held.size());
  to_coordinator([this, index, id = worker.id, wanted] {
    // Failures that are not committed yet are not known here.
    const auto waited =
        coordinator_->waits_for_commit() ? std::map<std::string, std::uint32_t>() : waiting_units(id);
    coordinator_->lease({.worker = id, .max_units = wanted, .loaded_scenes = {"s0"}}, now_,
                        [this, index, id, wanted, waited](const absl::StatusOr<LeaseDecision>& decision,
                                                          const std::vector<std::string>& isas) {
                          if (!decision.ok()) return;
                          trace_.add(*decision);
                          if (decision->leases.size() > wanted)
                            violate("a worker is given more than it asked for");
                          if (decision->leases.empty()) check_sent_away(workers_[index], id, waited);
                          check_order(workers_[index], *decision, waited);
                          for (const v1::Lease& lease : decision->leases)
                            check_grant(workers_[index], lease.token());
                          to_worker(index,
                                    [this, index, decision, isas] { receive_units(index, *decision, isas); });
                        });
  });
}

void Simulation::check_grant(const Worker& worker, const v1::LeaseToken& token) {
  Promise& promise = promises_.at(token.job_id());
  const std::string unit = absl::StrCat(token.job_id(), "/", token.unit_index());
  if (promise.cancel_acknowledged)
    return violate(absl::StrCat(unit, " was given out after its job was cancelled"));
  for (const std::uint32_t one : units_of(token)) {
    const auto live = promise.live.find(one);
    if (live == promise.live.end() || coordinator_->revokes(token.job_id(), live->second + 1)) continue;
    Promise::Result& result = promise.journaled[live->second];
    if (!result.acknowledged) continue;
    // A second opinion is asked for once, of another host and for the same units; more only to decide between
    // two, of which is not known here what is not committed yet.
    const bool of_phase = !promise.request.plan->is_of_picture(one);
    const bool second_opinion =
        (liars_ || audits_ || of_phase) && result.host != worker.host && result.units == covered_by(token);
    // A unit of a phase is asked for once more in each life of a coordinator, when somebody cannot read it.
    const std::uint64_t most = of_phase ? 2 + counts_.coordinator_deaths : 1;
    const bool again = one == token.unit_index() && ++result.second_leases > most;
    if (!second_opinion || (again && !result.disputed && !coordinator_->waits_for_commit())) {
      return violate(absl::StrCat(unit, " was acknowledged and is given out again"));
    }
  }
}

/// Pending units of jobs that this worker's arithmetic does not keep it from.
std::map<std::string, std::uint32_t> Simulation::waiting_units(const std::string& worker) const {
  std::map<std::string, std::uint32_t> waiting;
  for (const auto& [job, promise] : promises_) {
    const absl::StatusOr<JobView> view = coordinator_->scheduler().job(job);
    if (!view.ok() || view->paused || (view->state != v1::QUEUED && view->state != v1::RUNNING)) continue;
    if (coordinator_->scheduler().isa_for(worker, job).empty()) continue;
    waiting[job] = view->units_pending;
  }
  return waiting;
}

/// First come, first served within a user and priority: while an older job had units left, a younger one gets
/// none.
void Simulation::check_order(const Worker& worker, const LeaseDecision& decision,
                             const std::map<std::string, std::uint32_t>& waited) {
  // Slow workers may be of no use to the older one.
  // A job whose class is not chosen yet waits for that.
  if (job_order_ != JobOrder::kFirstCome || worker.slowness > 1 || settle_ > Time{0}) return;
  std::map<std::string, std::uint32_t> given;
  for (const v1::Lease& lease : decision.leases)
    given[lease.token().job_id()] += covered_by(lease.token()).ranges;
  for (const auto& [older, units] : waited) {
    const Promise& first = promises_.at(older);
    // Units that failed may be for others, and so may the whole job for a while.
    if (first.failed || first.request.max_workers > 0 || given[older] >= units) continue;
    for (const auto& [younger, count] : given) {
      const Promise& second = promises_.at(younger);
      if (count == 0 || second.arrived <= first.arrived || first.request.user != second.request.user)
        continue;
      if (first.request.priority != second.request.priority || audits_ || liars_) continue;
      // Its units that were lost with several workers go before all others, to somebody alone.
      if (second.failed) continue;
      violate(absl::StrCat(younger, " goes before ", older, " of the same user"));
    }
  }
}

/// Whoever has nothing in hand gets a unit where one waits that it may take, unless it is slow. `waited`:
/// those that waited when it asked, for others may have come back since.
void Simulation::check_sent_away(const Worker& worker, const std::string& id,
                                 const std::map<std::string, std::uint32_t>& waited) {
  if (chaos_ || worker.slowness > 1 || !usual_pace_is_common_) return;
  const Scheduler& scheduler = coordinator_->scheduler();
  // Answers that were lost may have been leases, which run out. A look at all workers, so it comes last.
  const auto is_free = [&] {
    const std::vector<WorkerView> views = scheduler.workers();
    return std::all_of(views.begin(), views.end(), [&](const WorkerView& view) {
      return view.info.id != id || (view.leases == 0 && view.quarantine.empty());
    });
  };
  for (const auto& [job, promise] : promises_) {
    const absl::StatusOr<JobView> view = scheduler.job(job);
    // Units that failed or were lost go to other hosts first, or to somebody alone.
    if (!view.ok() || view->paused || promise.request.max_workers > 0 || promise.failed) continue;
    if (view->state != v1::QUEUED && view->state != v1::RUNNING) continue;
    // For machines that round otherwise, or not yet chosen whose.
    if (scheduler.isa_for(id, job).empty()) continue;
    if (settle_ > Time{0} && !promise.request.any_class && view->classes.empty()) continue;
    const auto before = waited.find(job);
    if (before == waited.end() || before->second == 0) continue;
    if (view->units_pending > 0 && is_free())
      violate(absl::StrCat(worker.host, " is sent away though ", job, " has units"));
  }
}

/// In every arithmetic class: jobs are done within one, and paces compared within jobs.
bool Simulation::is_usual_pace_common() const {
  std::map<std::string, std::pair<std::size_t, std::size_t>> of_class;  // slow workers, all workers
  for (const Worker& worker : workers_) {
    for (const std::string& name : worker.classes) {
      of_class[name].first += worker.slowness > 1;
      ++of_class[name].second;
    }
  }
  return std::all_of(of_class.begin(), of_class.end(),
                     [](const auto& entry) { return 2 * entry.second.first < entry.second.second; });
}

/// Equal machines are held for equal, whatever their units cost.
void Simulation::check_paces() {
  if (std::any_of(workers_.begin(), workers_.end(), [](const Worker& worker) { return worker.slowness > 1; }))
    return;
  for (const WorkerView& view : coordinator_->scheduler().workers()) {
    if (view.slowness > 1.2 || view.slowness < 1 / 1.2) {
      violate(absl::StrCat(view.info.host, " is taken for ", view.slowness, " times slow"));
    }
  }
}

bool Simulation::poisonous(const v1::LeaseToken& token) const {
  if (!poison_ || token.job_id() != "j0") return false;
  for (const std::uint32_t unit : units_of(token)) {
    if (unit == 3) return true;
  }
  return false;
}

void Simulation::receive_units(std::size_t index, const LeaseDecision& decision,
                               const std::vector<std::string>& isas) {
  Worker& worker = workers_[index];
  for (std::size_t i = 0; i < isas.size(); ++i) {
    const v1::LeaseToken& token = decision.leases[i].token();
    const auto known = std::find_if(worker.held.begin(), worker.held.end(),
                                    [&](const Held& held) { return same(held.token, token); });
    if (known != worker.held.end()) continue;  // the reply came twice
    const Time cost(std::lround(1 + effort_of(token).milliseconds * worker.slowness));
    worker.held.push_back({.token = token,
                           .arithmetic_class = class_of(worker, isas[i]),
                           .done_at = now_ + cost,
                           .cost = cost});
    at(cost, [this, index, token, life = worker.life] {
      Worker& there = workers_[index];
      if (!there.alive || there.life != life) return;
      const auto held = std::find_if(there.held.begin(), there.held.end(),
                                     [&](const Held& h) { return same(h.token, token); });
      if (held == there.held.end()) return;
      if (poisonous(token)) return kill_worker(index);
      held->sent = true;
      if (now_ >= there.hangs_until) deliver(index, *held);
    });
  }
}

void Simulation::deliver(std::size_t index, const Held& held) {
  const v1::LeaseToken token = held.token;
  const Worker& worker = workers_[index];
  const auto settled = [this, index, token](const absl::Status& status) {
    if (status.ok()) {
      Promise& promise = promises_.at(token.job_id());
      bool durable = false;
      for (const std::uint32_t unit : units_of(token)) {
        const auto live = promise.live.find(unit);
        if (live == promise.live.end()) continue;
        durable = true;  // cut in another way, perhaps
        Promise::Result& result = promise.journaled[live->second];
        result.acknowledged |= result.units == covered_by(token);
      }
      if (!durable && promise.ended == v1::JOB_STATE_UNSPECIFIED && !liars_ && fail_ == 0) {
        violate("a result is acknowledged that is not durable");
      }
    }
    to_worker(index, [this, index, token, status] {
      if (absl::IsNotFound(status)) {
        workers_[index].id.clear();  // it registers again, and delivers then
      } else {
        forget(workers_[index], token);
      }
    });
  };
  if (worker.id.empty()) return;
  if (chaos_ && chance(fail_)) {
    return to_coordinator([this, id = worker.id, token, settled] {
      coordinator_->fail(id, token, now_, [settled](const absl::Status& status) {
        settled(status.ok() ? absl::CancelledError("reported as failed") : status);
      });
    });
  }
  const bool lies = chaos_ && worker.liar && pick(2) == 0;
  const DeliveredResult result{.fingerprint = truth_of(promises_.at(token.job_id()), covered_by(token),
                                                       held.arithmetic_class, token.inputs()) +
                                              (lies ? 1 + index : 0),
                               .cost = held.cost,
                               .work = effort_of(token).rays};
  to_coordinator([this, id = worker.id, token, result, settled] {
    coordinator_->complete(id, token, result, now_, settled);
  });
}

void Simulation::forget(Worker& worker, const v1::LeaseToken& token) {
  std::erase_if(worker.held, [&](const Held& held) { return same(held.token, token); });
}

}  // namespace tessera::server
