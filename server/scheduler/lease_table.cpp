#include "scheduler/lease_table.h"

#include <algorithm>

namespace tessera::server {

LeaseId LeaseTable::add(Lease lease) {
  const LeaseId id = next_id_++;
  for (const std::uint32_t unit : lease.units) by_unit_[{lease.job, unit}].push_back(id);
  by_worker_[lease.worker].insert(id);
  deadlines_.emplace(lease.deadline, id);
  leases_.emplace(id, std::move(lease));
  return id;
}

Lease LeaseTable::remove(LeaseId id) {
  const auto found = leases_.find(id);
  Lease lease = std::move(found->second);
  leases_.erase(found);

  for (const std::uint32_t number : lease.units) {
    const auto unit = by_unit_.find({lease.job, number});
    std::erase(unit->second, id);
    if (unit->second.empty()) by_unit_.erase(unit);
  }

  const auto worker = by_worker_.find(lease.worker);
  worker->second.erase(id);
  if (worker->second.empty()) by_worker_.erase(worker);
  return lease;
}

void LeaseTable::refresh(LeaseId id, Time deadline) {
  Lease& lease = leases_.at(id);
  lease.deadline = std::max(lease.deadline, deadline);
}

std::vector<LeaseId> LeaseTable::of_unit(std::uint64_t job, std::uint32_t unit) const {
  const auto found = by_unit_.find({job, unit});
  return found == by_unit_.end() ? std::vector<LeaseId>{} : found->second;
}

std::vector<LeaseId> LeaseTable::of_worker(const std::string& worker) const {
  const auto found = by_worker_.find(worker);
  if (found == by_worker_.end()) return {};
  std::vector<LeaseId> ids(found->second.begin(), found->second.end());
  std::sort(ids.begin(), ids.end());  // the same order in every run
  return ids;
}

std::size_t LeaseTable::count_of_worker(const std::string& worker) const {
  const auto found = by_worker_.find(worker);
  return found == by_worker_.end() ? 0 : found->second.size();
}

std::vector<LeaseId> LeaseTable::of_job(std::uint64_t job) const {
  std::vector<LeaseId> ids;
  for (const auto& [id, lease] : leases_) {
    if (lease.job == job) ids.push_back(id);
  }
  std::sort(ids.begin(), ids.end());
  return ids;
}

std::optional<LeaseId> LeaseTable::expired(Time now) {
  while (!deadlines_.empty() && deadlines_.top().first <= now) {
    const LeaseId id = deadlines_.top().second;
    const auto found = leases_.find(id);
    if (found != leases_.end() && found->second.deadline <= now) return id;
    deadlines_.pop();
    if (found != leases_.end()) deadlines_.emplace(found->second.deadline, id);
  }
  return std::nullopt;
}

}  // namespace tessera::server
