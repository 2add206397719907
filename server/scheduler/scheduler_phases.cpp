// Steps of jobs: which units may be given out, and what follows for those that read a result that counts no
// more [docs/decisions/0026-phases.md].
#include "absl/strings/str_cat.h"
#include "scheduler/scheduler.h"

namespace tessera::server {

/// Opens the steps whose units have all that they read.
void Scheduler::open_steps(Job& job) {
  const WorkPlan& plan = *job.request.plan;
  UnitLedger& units = job.units;
  while (units.open_end() < units.count() && units.settled() && units.set_aside() == 0) {
    units.open_until(plan.step_end(units.open_end()));
    // Units of other steps cost something else.
    job.mean_cost_ms = 0;
    job.mean_duration = Time{0};
  }
}

/// LeaseToken.inputs of the unit; none where something that it reads is not there.
std::optional<std::uint64_t> Scheduler::inputs_of(const Job& job, std::uint32_t unit) {
  std::vector<ResultFingerprint> inputs;
  for (const std::uint32_t input : job.request.plan->phases().inputs(unit)) {
    if (job.units.state(input) != UnitState::kDone) return std::nullopt;
    inputs.push_back(job.units.result(input).fingerprint);
  }
  return inputs_key(inputs);
}

absl::Status Scheduler::check_inputs(const Job& job, const v1::LeaseToken& token) {
  if (inputs_of(job, token.unit_index()) == token.inputs()) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat("unit ", token.unit_index(), " of job ", token.job_id(),
                                                    " was made of results that count no more"));
}

/// What was made of a unit's result, which counts no more, is made anew; the last first, so that a crash in
/// between leaves nothing that is made of what is not there.
void Scheduler::revoke_dependents(Job& job, std::uint32_t source) {
  if (job.request.plan->is_of_picture(source)) return;
  const PhasePlan& phases = job.request.plan->phases();
  const std::uint32_t step_end = phases.step_end(phases.step_begin(source));
  const std::uint32_t phase_end = phases.phase_end(source);
  for (std::uint32_t unit = job.units.open_end(); unit-- > step_end;) {
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

/// Nobody is at the unit, and what happened to it is forgotten: perhaps it was for what it read.
void Scheduler::begin_anew(Job& job, std::uint32_t unit) {
  for (const LeaseId lease : leases_.of_unit(job.number, unit)) drop_lease(lease);
  job.failures.erase(unit);
  job.shorter_runs.erase(unit);
  forgive(job, unit);
  if (job.units.state(unit) == UnitState::kSetAside) job.units.put_back(unit);
}

/// After a restart: results of steps that come after one that is not done, as a damaged journal may have
/// them.
void Scheduler::revoke_orphans(Job& job) {
  if (!job.open() || job.units.open_end() == job.units.count()) return;
  for (std::uint32_t unit = job.units.count(); unit-- > job.units.open_end();) {
    if (job.units.state(unit) == UnitState::kDone && !inputs_of(job, unit))
      revoke_alone(job, job.units.result(unit));
  }
}

}  // namespace tessera::server
