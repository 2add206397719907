#include "scheduler/policy/eligibility.h"

#include <algorithm>

#include "scheduler/identity.h"
#include "scheduler/policy/unit_failures.h"

namespace tessera::server {

bool Eligibility::may_work_on(const FarmWorker& worker, const FarmJob& job, Time now) const {
  if (worker.draining || !trust_.trusts(worker.info.host)) return false;
  if (classes_.settling(job, now) || classes_.class_for(worker, job) == nullptr) return false;
  if (!has_tags(worker.info, job.request.required_tags)) return false;
  if (const auto host = job.hosts.find(worker.info.host);
      host != job.hosts.end() && now < host->second.barred_until) {
    return false;
  }
  const std::uint32_t most = job.request.max_workers;
  return most == 0 || job.holders.size() < most || job.holders.contains(worker.info.id);
}

bool Eligibility::awaits_another(const FarmJob& job, const std::vector<UnitFailure>& failures) const {
  if (!failed_too_often(failures)) return false;
  const std::string identity = identity_of(failures.front().host);
  const bool alone = std::all_of(failures.begin(), failures.end(), [&](const UnitFailure& failure) {
    return identity_of(failure.host) == identity;
  });
  return alone && std::any_of(state_.workers.begin(), state_.workers.end(), [&](const auto& entry) {
           const FarmWorker& worker = entry.second;
           return identity_of(worker.info.host) != identity && may_work_on(worker, job, worker.last_seen);
         });
}

bool Eligibility::avoids(const FarmWorker& worker, const FarmJob& job, std::uint32_t unit) const {
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
  return failed_on(worker.info.host) &&
         std::any_of(state_.workers.begin(), state_.workers.end(), [&](const auto& entry) {
           const FarmWorker& other = entry.second;
           return !failed_on(other.info.host) && may_work_on(other, job, other.last_seen);
         });
}

}  // namespace tessera::server
