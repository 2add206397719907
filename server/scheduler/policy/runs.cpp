#include "scheduler/policy/runs.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tessera::server {

/// Expected time of each of these units on a thread of a usual worker, in ms: that of those of the same tile
/// that came last, whose pixels are the same.
double Runs::unit_cost_ms(const FarmJob& job, const UnitRun& units) const {
  const WorkPlan& plan = *job.request.plan;
  const bool of_tiles = !job.tile_cost_ms.empty() && plan.is_of_picture(units.first);
  const double of_tile = of_tiles ? job.tile_cost_ms[plan.tile_of(units.first)] : 0;
  if (of_tile > 0) return of_tile;
  return job.mean_unit_cost_ms > 0 ? job.mean_unit_cost_ms : kUnknownUnitCostMs;
}

std::int64_t Runs::charge_for(const FarmJob& job, const UnitRun& units) const {
  double unit_ms = unit_cost_ms(job, units);
  if (job.mean_unit_cost_ms > 0) unit_ms = std::min(unit_ms, kMostSpread * job.mean_unit_cost_ms);
  return std::max<std::int64_t>(1, std::llround(units.count * unit_ms));
}

Time Runs::expected_cost(const FarmWorker& worker, const FarmJob& job, const UnitRun& units) const {
  const double usual_ms = units.count * unit_cost_ms(job, units);
  return Time(std::max<std::int64_t>(1, static_cast<std::int64_t>(usual_ms * worker.slowness)));
}

UnitRun Runs::run_from(const FarmWorker& worker, const FarmJob& job, std::uint32_t unit) const {
  UnitRun run = job.request.plan->longest_run(unit);
  const std::uint32_t possible = std::exchange(run.count, 1);
  const double wanted = longest_run(worker, job, run);
  while (2 * run.count <= possible && 2 * run.count <= wanted) {
    UnitRun longer = run;
    longer.count *= 2;
    for (std::uint32_t i = 0; i < longer.count; ++i) {
      const bool taken = i < run.count;
      if (!fits_run(job, longer[i], longer.count) ||
          (!taken && i > 0 && job.units.state(longer[i]) != UnitState::kPending)) {
        return run;
      }
    }
    run = longer;
  }
  return run;
}

bool Runs::fits_run(const FarmJob& job, std::uint32_t unit, std::uint32_t count) const {
  if (job.failures.contains(unit) || job.dangerous.contains(unit)) return false;
  const auto shorter = job.shorter_runs.find(unit);
  return shorter == job.shorter_runs.end() || count <= shorter->second;
}

/// How many units of the tile may be leased to this worker as one, at most. The first of each tile are to be
/// there soon; towards the end of the job no more than half of a thread's part of what is left
/// [Polychronopoulos1987], but not so few that the lease would be most of the work.
double Runs::longest_run(const FarmWorker& worker, const FarmJob& job, const UnitRun& units) const {
  if (job.mean_unit_cost_ms == 0) return 1;
  const double unit_ms = unit_cost_ms(job, units) * worker.slowness;
  const auto longest = static_cast<double>(state_.options.longest_run.count());
  const double worthwhile = std::min(longest, static_cast<double>(state_.options.short_run.count()));
  if (job.request.plan->begins_tile(units.first)) return worthwhile / unit_ms;
  // A slow thread's part has fewer units, and takes it as long.
  const double part = static_cast<double>(job.units.pending()) * job.mean_unit_cost_ms /
                      (2.0 * static_cast<double>(state_.total_threads));
  return std::clamp(part, worthwhile, longest) / unit_ms;
}

}  // namespace tessera::server
