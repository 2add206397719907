#include "scheduler/policy/steps.h"

#include <algorithm>
#include <set>
#include <vector>

#include "absl/strings/str_cat.h"
#include "scheduler/identity.h"

namespace tessera::server {

void Steps::open(FarmJob& job) {
  const WorkPlan& plan = *job.request.plan;
  UnitLedger& units = job.units;
  while (units.open_end() < units.count() && units.settled() && units.set_aside() == 0 &&
         job.suspected.empty()) {
    units.open_until(plan.step_end(units.open_end()));
    // Units of other steps cost something else.
    job.mean_unit_cost_ms = 0;
    job.latest_costs.clear();
    job.mean_lease_duration = Time{0};
  }
}

std::optional<std::uint64_t> Steps::inputs_of(const FarmJob& job, std::uint32_t unit) {
  std::vector<ResultFingerprint> inputs;
  for (const std::uint32_t input : job.request.plan->phases().inputs(unit)) {
    if (job.units.state(input) != UnitState::kDone) return std::nullopt;
    inputs.push_back(job.units.result(input).fingerprint);
  }
  return inputs_key(inputs);
}

absl::Status Steps::check_inputs(const FarmJob& job, const v1::LeaseToken& token) {
  if (inputs_of(job, token.unit_index()) == token.inputs()) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat("unit ", token.unit_index(), " of job ", token.job_id(),
                                                    " was made of results that count no more"));
}

void Steps::revoke(FarmJob& job, const AcceptedResult& result) {
  revoke_dependents(job, result.units.first);
  revoke_alone(job, result);
}

void Steps::revoke_all(FarmJob& job) {
  for (const AcceptedResult& result : job.units.results()) {
    // It may have been made of another one of them.
    if (job.units.state(result.units.first) == UnitState::kDone &&
        job.units.result(result.units.first).sequence == result.sequence) {
      revoke(job, result);
    }
  }
}

void Steps::revoke_alone(FarmJob& job, const AcceptedResult& result) {
  job.audits.erase(result.units.first);
  job.audited.erase(result.units.first);
  job.spots.erase(result.units.first);
  job.alarms.erase(result.units.first);
  if (job.spots.empty()) state_.checking.erase(job.number);
  for (std::set<std::uint32_t>* const known : {&job.confirmed, &job.suspected, &job.questioned})
    known->erase(result.units.first);
  for (const LeaseId lease : state_.leases.of_unit(job.number, result.units.first)) book_.drop(lease);
  FarmEvent& event = state_.record(FarmEvent::Kind::kRevoked, job.request.id);
  event.unit = result.units.first;
  event.value = result.sequence;
  if (result.host < state_.hosts_by_number.size()) {
    event.host = state_.hosts_by_number[result.host];
    const auto standing = job.standing_by_identity.find(identity_of(event.host));
    if (standing != job.standing_by_identity.end()) standing->second.forget(result.sequence);
  }
  for (const std::uint32_t unit : result.units) job.units.put_back(unit);
  ++job.revision;
}

/// Makes anew all that was made of a unit's result, which counts no more; the last first, so that a crash in
/// between leaves nothing that is made of what is not there.
void Steps::revoke_dependents(FarmJob& job, std::uint32_t source) {
  if (job.request.plan->is_of_picture(source)) return;
  const PhasePlan& phases = job.request.plan->phases();
  const std::uint32_t step_end = phases.step_end(phases.step_begin(source));
  const std::uint32_t phase_end = phases.phase_end(source);
  for (std::uint32_t unit = std::max(job.reached, job.units.open_end()); unit-- > step_end;) {
    if (unit >= phase_end && job.units.state(unit) == UnitState::kDone)
      revoke_alone(job, job.units.result(unit));
    begin_anew(job, unit);
  }
  std::vector<std::uint32_t> readers;
  for (auto reader = phases.reader(source); reader; reader = phases.reader(*reader))
    readers.push_back(*reader);
  for (auto reader = readers.rbegin(); reader != readers.rend(); ++reader) {
    if (job.units.state(*reader) == UnitState::kDone) revoke_alone(job, job.units.result(*reader));
  }
  job.units.close_from(step_end);
}

void Steps::close(FarmJob& job, std::uint32_t begin) {
  for (std::uint32_t unit = job.units.open_end(); unit-- > begin;) {
    if (job.units.state(unit) != UnitState::kDone) begin_anew(job, unit);
  }
  job.reached = std::max(job.reached, job.units.open_end());
  if (begin < job.units.open_end()) job.units.close_from(begin);
}

/// Nobody is at the unit, and what happened to it is forgotten: perhaps it was for what it read.
void Steps::begin_anew(FarmJob& job, std::uint32_t unit) {
  for (const LeaseId lease : state_.leases.of_unit(job.number, unit)) book_.drop(lease);
  job.failures.erase(unit);
  job.shorter_runs.erase(unit);
  faults_.forgive(job, unit);
  if (job.units.state(unit) == UnitState::kSetAside) job.units.put_back(unit);
}

void Steps::revoke_orphans(FarmJob& job) {
  if (!job.open() || job.units.open_end() == job.units.count()) return;
  for (std::uint32_t unit = job.units.count(); unit-- > job.units.open_end();) {
    if (job.units.state(unit) == UnitState::kDone && !inputs_of(job, unit))
      revoke_alone(job, job.units.result(unit));
  }
}

}  // namespace tessera::server
