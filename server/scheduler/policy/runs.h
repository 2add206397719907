// How many units of a tile are leased as one, and how long they may take [docs/decisions/0020-unit-size.md].
#pragma once

#include "scheduler/farm_state.h"

namespace tessera::server {

class Runs {
 public:
  static constexpr std::int64_t kUnknownUnitCostMs = 1000;  // assumed before any unit is done
  // How far the cost of one unit may be from those of others and still be charged in full. Costs over two
  // decades are log-normal with a standard deviation of a factor of three: three of these.
  static constexpr double kMostSpread = 30;

  explicit Runs(const FarmState& state) : state_(state) {}

  /// Work of these units, in ms of a thread of a usual worker.
  std::int64_t charge_for(const FarmJob& job, const UnitRun& units) const;
  /// Expected time of these units on a thread of this worker.
  Time expected_cost(const FarmWorker& worker, const FarmJob& job, const UnitRun& units) const;
  /// Units from a pending one on that this worker had better do as one.
  UnitRun run_from(const FarmWorker& worker, const FarmJob& job, std::uint32_t unit) const;
  /// Whether nothing is known of the unit for which it should go alone, or in a shorter run than one of
  /// `count`.
  bool fits_run(const FarmJob& job, std::uint32_t unit, std::uint32_t count) const;

 private:
  double unit_cost_ms(const FarmJob& job, const UnitRun& units) const;
  double longest_run(const FarmWorker& worker, const FarmJob& job, const UnitRun& units) const;

  const FarmState& state_;
};

}  // namespace tessera::server
