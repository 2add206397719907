// Jobs: from being added to being forgotten, what is told of them, and what a restart brings back.
#include <algorithm>

#include "absl/strings/str_cat.h"
#include "scheduler/identity.h"
#include "scheduler/scheduler.h"
#include "wire/arithmetic_class.h"

namespace tessera::server {
namespace {

absl::Status no_such_job(std::string_view id) {
  return absl::NotFoundError(absl::StrCat("there is no job ", std::string(id)));
}

const char* past_tense(v1::JobState state) {
  switch (state) {
    case v1::CANCELLED:
      return "was cancelled";
    case v1::FAILED:
      return "failed";
    case v1::INCOMPLETE:
      return "is over, though incomplete";
    default:
      return "is done";
  }
}

}  // namespace

absl::StatusOr<const Scheduler::Job*> Scheduler::find_job(std::string_view id) const {
  const auto found = jobs_by_id_.find(std::string(id));
  if (found == jobs_by_id_.end()) return no_such_job(id);
  return found->second;
}

absl::StatusOr<Scheduler::Job*> Scheduler::find_job(std::string_view id) {
  const auto found = jobs_by_id_.find(std::string(id));
  if (found == jobs_by_id_.end()) return no_such_job(id);
  return found->second;
}

absl::StatusOr<Scheduler::Job*> Scheduler::find_open_job(std::string_view id) {
  absl::StatusOr<Job*> job = find_job(id);
  if (!job.ok() || (*job)->open()) return job;
  return absl::FailedPreconditionError(
      absl::StrCat("job ", (*job)->request.id, " ", past_tense((*job)->state)));
}

// ---------------------------------------------------------------- changes

absl::Status Scheduler::add_job(JobRequest request) {
  if (jobs_by_id_.contains(request.id))
    return absl::AlreadyExistsError(absl::StrCat("there is a job ", request.id));
  auto job = std::make_unique<Job>(jobs_added_++, std::move(request));
  jobs_by_id_.emplace(job->request.id, job.get());
  open_steps(*job);
  take_turns(*job);
  jobs_.emplace(job->number, std::move(job));
  return absl::OkStatus();
}

absl::Status Scheduler::adopt(std::string_view id, const std::string& from,
                              const std::vector<AdoptedResult>& results) {
  const absl::StatusOr<Job*> found = find_job(id);
  if (!found.ok()) return found.status();
  Job& job = **found;
  const bool fit = std::all_of(results.begin(), results.end(), [&](const AdoptedResult& result) {
    const std::string& name = result.arithmetic_class;
    return (job.request.any_class || name == results.front().arithmetic_class) &&
           (job.request.isa.empty() || job.request.isa == wire::isa_of(name));
  });
  if (job.results > 0 || !fit) {
    return absl::FailedPreconditionError(absl::StrCat(
        "job ", job.request.id, " is not new, or is bound to another ISA or class than job ", from));
  }
  if (results.empty()) return absl::OkStatus();
  bind(job, results.front().arithmetic_class);
  for (const AdoptedResult& result : results) {
    job.units.finish({.fingerprint = result.fingerprint,
                      .sequence = ++job.results,
                      .host = number_of_host(result.host),
                      .units = result.units});
    job.renderers.insert(number_of_host(result.host));
    note_class(job, result.host, job.results, result.arithmetic_class);
  }
  open_steps(job);
  job.state = v1::RUNNING;
  job.adopted = job.units.done();
  job.adopted_from = from;
  FarmEvent& event = record(FarmEvent::Kind::kAdopted, job.request.id);
  event.value = job.adopted;
  event.text = from;
  settle(job);
  return absl::OkStatus();
}

/// An open job takes its turns, unless it is paused.
void Scheduler::take_turns(Job& job) {
  leave_turns(job);
  if (!job.open() || job.paused) return;
  turns_.add(job.number, job.request.priority, job.request.user, job.load_ms);
  jobs_by_scene_[job.request.scene_digest].insert(job.number);
}

void Scheduler::leave_turns(const Job& job) {
  turns_.remove(job.number);
  const auto scene = jobs_by_scene_.find(job.request.scene_digest);
  if (scene == jobs_by_scene_.end()) return;
  scene->second.erase(job.number);
  if (scene->second.empty()) jobs_by_scene_.erase(scene);
}

absl::StatusOr<bool> Scheduler::cancel_job(std::string_view id) {
  const absl::StatusOr<Job*> job = find_job(id);
  if (!job.ok()) return job.status();
  if (!(*job)->open()) return false;
  end_job(**job, v1::CANCELLED, "");
  return true;
}

absl::Status Scheduler::pause_job(std::string_view id, bool paused) {
  const absl::StatusOr<Job*> found = find_open_job(id);
  if (!found.ok()) return found.status();
  Job& job = **found;
  if (job.paused == paused) return absl::OkStatus();
  job.paused = paused;
  take_turns(job);
  record(FarmEvent::Kind::kPaused, job.request.id).value = paused;
  return absl::OkStatus();
}

absl::Status Scheduler::set_priority(std::string_view id, std::int32_t priority) {
  const absl::StatusOr<Job*> found = find_open_job(id);
  if (!found.ok()) return found.status();
  Job& job = **found;
  if (job.request.priority == priority) return absl::OkStatus();
  job.request.priority = priority;
  take_turns(job);
  record(FarmEvent::Kind::kPriority, job.request.id).value = priority;
  return absl::OkStatus();
}

absl::Status Scheduler::forget_job(std::string_view id) {
  const absl::StatusOr<Job*> job = find_job(id);
  if (!job.ok()) return job.status();
  if ((*job)->open())
    return absl::FailedPreconditionError(absl::StrCat("job ", std::string(id), " is not over"));
  const std::uint64_t number = (*job)->number;
  jobs_by_id_.erase((*job)->request.id);
  jobs_.erase(number);
  return absl::OkStatus();
}

absl::StatusOr<JobView> Scheduler::job(std::string_view id) const {
  const absl::StatusOr<const Job*> found = find_job(id);
  if (!found.ok()) return found.status();
  const Job& job = **found;
  const UnitLedger& units = job.units;
  JobView view{.state = job.state,
               .units_total = units.count(),
               .units_done = units.done(),
               .units_leased = units.leased(),
               .units_set_aside = units.set_aside(),
               .units_open = units.open_end(),
               .units_pending = units.pending(),
               .isa = job.request.isa,
               .error = job.error,
               .priority = job.request.priority,
               .paused = job.paused,
               .revision = job.revision,
               .notes = job.notes,
               .set_aside = {},
               .audits = static_cast<std::uint32_t>(job.audited.size()),
               .audits_out = static_cast<std::uint32_t>(job.audits.out()),
               .units_adopted = job.adopted,
               .adopted_from = job.adopted_from,
               .classes = job.classes.all(),
               .workers = static_cast<std::uint32_t>(job.holders.size())};
  if (!view.classes.empty()) view.isa = isas_of(view.classes);
  if (units.set_aside() == 0) return view;
  for (const auto& [unit, failures] : job.failures) {
    if (units.state(unit) == UnitState::kSetAside) view.set_aside.push_back({unit, failures});
  }
  std::sort(view.set_aside.begin(), view.set_aside.end(),
            [](const SetAsideView& a, const SetAsideView& b) { return a.unit < b.unit; });
  if (view.set_aside.size() > kMaxListed) view.set_aside.resize(kMaxListed);
  return view;
}

std::string Scheduler::waiting_for(std::string_view id, Time now) const {
  const absl::StatusOr<const Job*> found = find_job(id);
  if (!found.ok() || !(*found)->open() || (*found)->leases > 0) return "";
  const Job& job = **found;
  if (job.paused) return "the job is paused";
  if (workers_.empty()) return "there is no worker";
  std::size_t with_tags = 0, with_isa = 0, free = 0;
  for (const auto& [name, worker] : workers_) {
    if (worker.draining || !trusts(worker.info.host)) continue;
    if (!has_tags(worker.info, job.request.required_tags)) continue;
    ++with_tags;
    if (class_for(worker, job) == nullptr) continue;
    ++with_isa;
    free += may_work_on(worker, job, now);
  }
  if (with_tags == 0)
    return job.request.required_tags.empty() ? "every worker drains or is in quarantine"
                                             : "no worker has the tags that the job requires";
  if (with_isa == 0) {
    const std::string& bound = job.classes.bound();
    return bound.empty()
               ? absl::StrCat("no worker supports ", job.request.isa)
               : absl::StrCat("the job is bound to ", bound, ", and no worker of that class is left");
  }
  if (settling(job, now))
    return "workers have only just come; it is bound to the class of most of them in a moment";
  if (free == 0) return "the job failed on every host that could take it; they are tried again later";
  return "other jobs go first, or the workers are still busy";
}

void Scheduler::end_job(Job& job, v1::JobState state, std::string error) {
  for (const LeaseId id : job.leases > 0 ? leases_.of_job(job.number) : std::vector<LeaseId>{})
    drop_lease(id);
  leave_turns(job);
  auditing_.erase(job.number);
  endangered_.erase(job.number);
  job.state = state;
  job.error = std::move(error);
  job.audits.clear();
  job.dangerous.clear();
  job.shorter_runs.clear();
  job.tile_cost_ms = {};
  job.hosts.clear();
  job.scene_faults.clear();
  job.renderers.clear();
  // The failures of an incomplete job are what its report consists of.
  if (state != v1::INCOMPLETE) job.failures.clear();
  FarmEvent& event = record(FarmEvent::Kind::kEnded, job.request.id);
  event.value = state;
  event.text = job.error;
}

void Scheduler::settle(Job& job) {
  if (!job.open() || !job.units.settled()) return;
  job.audits.erase_if([&](std::uint32_t unit, const Audit& audit) {
    if (!job.audits.waits(unit) || anyone_can_audit(job, audit)) return false;
    if (audit.opinions.size() > 1) {
      note(job, absl::StrCat("unit ", unit, ": ", short_name(audit.opinions[0].first), " and ",
                             short_name(audit.opinions[1].first),
                             " disagree, and there is no third host to decide"));
    }
    return true;
  });
  if (!job.audits.empty()) return;
  if (job.units.set_aside() == 0) return end_job(job, v1::DONE, "");
  end_job(job, job.units.done() == 0 ? v1::FAILED : v1::INCOMPLETE, what_is_missing(job));
}

// ---------------------------------------------------------------- recovery

absl::Status Scheduler::restore_done(std::string_view id, const AcceptedResult& result) {
  const absl::StatusOr<Job*> job = find_job(id);
  if (!job.ok()) return job.status();
  UnitLedger& units = (*job)->units;
  for (const std::uint32_t unit : result.units) {
    if (unit < units.count() && units.state(unit) != UnitState::kDone) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("job ", std::string(id), " has no unit ", unit, " left to be done"));
  }
  units.finish(result);
  (*job)->renderers.insert(result.host);
  (*job)->results = std::max((*job)->results, result.sequence);
  (*job)->state = v1::RUNNING;
  return absl::OkStatus();
}

absl::Status Scheduler::restore_revoked(std::string_view id, std::uint32_t sequence) {
  const absl::StatusOr<Job*> job = find_job(id);
  if (!job.ok()) return job.status();
  (*job)->results = std::max((*job)->results, sequence);
  ++(*job)->revision;
  return absl::OkStatus();
}

}  // namespace tessera::server
