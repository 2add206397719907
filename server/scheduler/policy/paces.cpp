#include "scheduler/policy/paces.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "scheduler/identity.h"

namespace tessera::server {
namespace {

// Threads are measured by so many results of a worker, and count twice what was seen of them: not all are
// always busy.
constexpr std::uint32_t kResultsMeasured = 32;
constexpr double kThreadsBeyond = 2;

}  // namespace

bool Paces::measure(FarmJob& job, FarmWorker& worker, const Lease& lease, const DeliveredResult& result,
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
    job.pace.compare(worker.pace, state_.usual_pace, std::log(static_cast<double>(cost.count()) / work));
    worker.slowness = slowness_of(worker.pace, state_.usual_pace);
    if (++state_.results_since_pace_comparison > state_.workers.size() / 4) compare_workers();
  }
  const double cost_ms = std::chrono::duration<double, std::milli>(cost).count();
  count_threads(worker, lease, cost_ms, now);
  // The time that a slow worker needs says little of the unit. Who is fast by its own account raises nobody's
  // cost.
  const double usual_ms = cost_ms / lease.units.count / std::max(1.0, worker.slowness);
  const std::string identity = identity_of(worker.info.host);
  const std::optional<double> others_ms = job.latest_costs.of_others(identity);
  const bool doubtful = others_ms && usual_ms * kDoubtful < *others_ms;
  const double borne_out_ms =
      others_ms ? std::clamp(usual_ms, *others_ms / Runs::kMostSpread, *others_ms * Runs::kMostSpread)
                : usual_ms;
  job.latest_costs.add(identity, borne_out_ms);
  job.mean_unit_cost_ms =
      job.mean_unit_cost_ms == 0 ? borne_out_ms : (7 * job.mean_unit_cost_ms + borne_out_ms) / 8;
  if (of_picture && plan.unit_count() - plan.phases().unit_count() > plan.tile_count()) {
    job.tile_cost_ms.resize(plan.tile_count());
    job.tile_cost_ms[plan.tile_of(lease.units.first)] = static_cast<float>(usual_ms);
  }
  state_.turns.remember(job.number, lease.charge_ms, now);
  job.mean_lease_duration =
      job.mean_lease_duration == Time{0} ? duration : (7 * job.mean_lease_duration + duration) / 8;
  return doubtful;
}

/// A worker's threads are its own claim until results show how many are at work at a time.
void Paces::count_threads(FarmWorker& worker, const Lease& lease, double worked_ms, Time now) {
  // Leases overlap; results come in order of time.
  worker.busy += now - std::max(lease.granted_at, worker.busy_until);
  worker.busy_until = now;
  worker.worked_ms += worked_ms;
  if (++worker.measured_results < kResultsMeasured || worker.busy == Time{0}) return;
  const double at_work = worker.worked_ms / static_cast<double>(worker.busy.count());
  const auto threads = static_cast<std::uint32_t>(
      std::clamp(std::ceil(kThreadsBeyond * at_work), 1.0, static_cast<double>(worker.info.threads)));
  // Small changes are not worth a new choice of classes.
  const std::uint32_t margin = worker.counted_threads / 4;
  if (threads + margin < worker.counted_threads || threads > worker.counted_threads + margin)
    classes_.count_threads(worker, threads);
}

/// Finds the usual pace anew, and each worker's relative to it.
void Paces::compare_workers() {
  state_.results_since_pace_comparison = 0;
  std::vector<const WorkerPace*> paces;
  paces.reserve(state_.workers.size());
  for (const auto& [id, worker] : state_.workers) paces.push_back(&worker.pace);
  state_.usual_pace = usual_pace(paces);
  for (auto& [id, worker] : state_.workers) worker.slowness = slowness_of(worker.pace, state_.usual_pace);
}

}  // namespace tessera::server
