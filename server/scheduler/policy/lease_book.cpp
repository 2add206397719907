#include "scheduler/policy/lease_book.h"

#include <algorithm>

#include "scheduler/identity.h"

namespace tessera::server {

void LeaseBook::add(FarmJob& job, FarmWorker& worker, Lease lease) {
  const UnitRun units = lease.units;
  lease.charge_ms = std::max<std::int64_t>(
      1, static_cast<std::int64_t>(lease.work_share * static_cast<double>(runs_.charge_for(job, units))));
  worker.load_ms += lease.charge_ms;
  worker.leased_units += units.count;
  job.leased_work_ms += lease.charge_ms;
  state_.turns.charge(job.number, lease.charge_ms);
  ++job.leases;
  ++job.holders[worker.info.id];
  const bool audit = lease.audit;
  if (!audit) index_only_lease(job, units, /*add=*/false);
  state_.leases.add(std::move(lease));
  if (!audit) index_only_lease(job, units, /*add=*/true);
}

void LeaseBook::drop(LeaseId id) {
  const Lease lease = state_.leases.get(id);
  FarmJob& job = *state_.jobs_by_number.at(lease.job);
  if (!lease.audit) index_only_lease(job, lease.units, /*add=*/false);
  state_.leases.remove(id);

  FarmWorker& worker = state_.workers.at(lease.worker);
  worker.load_ms -= lease.charge_ms;
  worker.leased_units -= lease.units.count;
  if (state_.leases.count_of_worker(lease.worker) == 0) worker.isolated = false;
  job.leased_work_ms -= lease.charge_ms;
  state_.turns.charge(job.number, -lease.charge_ms);
  --job.leases;
  if (const auto holder = job.holders.find(lease.worker); --holder->second == 0) job.holders.erase(holder);
  if (lease.spot != 0)
    return job.spots.give_back(lease.units.first, identity_of(state_.workers.at(lease.worker).info.host));
  if (lease.audit) return job.audits.give_back(lease.units.first);
  if (!state_.leases.of_unit(job.number, lease.units.first).empty()) {
    return index_only_lease(job, lease.units, /*add=*/true);
  }
  for (const std::uint32_t unit : lease.units) {
    if (job.units.state(unit) == UnitState::kLeased) job.units.put_back(unit);
  }
}

/// Takes the one lease of units into or out of the indices by which copies are chosen; none when there are
/// more.
void LeaseBook::index_only_lease(FarmJob& job, const UnitRun& units, bool add) {
  const std::vector<LeaseId> leases = state_.leases.of_unit(job.number, units.first);
  if (leases.size() != 1) return;
  const Lease& lease = state_.leases.get(leases.front());
  const std::pair by_age{lease.granted_at, leases.front()}, by_end{lease.expected_end, leases.front()};
  if (add) {
    job.only_leases.insert(by_age);
    if (lease.expected_end > Time{0}) job.by_end.insert(by_end);
  } else {
    job.only_leases.erase(by_age);
    job.by_end.erase(by_end);
  }
}

std::optional<LeaseId> LeaseBook::find(const FarmJob& job, const v1::LeaseToken& token,
                                       std::string_view worker) const {
  for (const LeaseId id : state_.leases.of_unit(job.number, token.unit_index())) {
    const Lease& lease = state_.leases.get(id);
    const bool same_units =
        lease.units.first == token.unit_index() && lease.units.count == std::max(token.ranges(), 1u);
    if (same_units && lease.attempt == token.attempt() && lease.epoch == token.epoch() &&
        lease.worker == worker)
      return id;
  }
  return std::nullopt;
}

std::optional<LeaseId> LeaseBook::find_own(const FarmJob& job, const UnitRun& units,
                                           std::string_view worker) const {
  for (const LeaseId id : state_.leases.of_unit(job.number, units.first)) {
    if (state_.leases.get(id).worker == worker && state_.leases.get(id).units == units) return id;
  }
  return std::nullopt;
}

Time LeaseBook::heartbeat_interval() const {
  const Time bearable{static_cast<std::int64_t>(state_.workers.size() * 1000 / kMaxHeartbeatsPerSecond)};
  return std::clamp(bearable, state_.options.heartbeat_interval,
                    std::max(state_.options.heartbeat_interval, kLongestHeartbeat));
}

Time LeaseBook::lease_time() const {
  return std::max(state_.options.lease_timeout, 5 * heartbeat_interval() / 2);
}

}  // namespace tessera::server
