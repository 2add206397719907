#include "scheduler/policy/paces.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tessera::server {

void Paces::measure(FarmJob& job, FarmWorker& worker, const Lease& lease, const DeliveredResult& result,
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
    if (++state_.results_since_comparison > state_.workers.size() / 4) compare_workers();
  }
  // The time that a slow worker needs says little of the unit.
  const double usual_ms =
      std::chrono::duration<double, std::milli>(cost).count() / lease.units.count / worker.slowness;
  job.mean_cost_ms = job.mean_cost_ms == 0 ? usual_ms : (7 * job.mean_cost_ms + usual_ms) / 8;
  if (of_picture && plan.unit_count() - plan.phases().unit_count() > plan.tile_count()) {
    job.tile_cost_ms.resize(plan.tile_count());
    job.tile_cost_ms[plan.tile_of(lease.units.first)] = static_cast<float>(usual_ms);
  }
  state_.turns.remember(job.number, lease.charge_ms, now);
  job.mean_duration = job.mean_duration == Time{0} ? duration : (7 * job.mean_duration + duration) / 8;
}

/// Finds the usual pace anew, and each worker's relative to it.
void Paces::compare_workers() {
  state_.results_since_comparison = 0;
  std::vector<const WorkerPace*> paces;
  paces.reserve(state_.workers.size());
  for (const auto& [id, worker] : state_.workers) paces.push_back(&worker.pace);
  state_.usual_pace = usual_pace(paces);
  for (auto& [id, worker] : state_.workers) worker.slowness = slowness_of(worker.pace, state_.usual_pace);
}

}  // namespace tessera::server
