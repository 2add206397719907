// Jobs: from being added to being forgotten, and what is told of them.
#include <algorithm>
#include <set>

#include "absl/strings/str_cat.h"
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

absl::StatusOr<const FarmJob*> Scheduler::find_job(std::string_view id) const {
  const auto found = state_.jobs_by_id.find(std::string(id));
  if (found == state_.jobs_by_id.end()) return no_such_job(id);
  return found->second;
}

absl::StatusOr<FarmJob*> Scheduler::find_job(std::string_view id) {
  const auto found = state_.jobs_by_id.find(std::string(id));
  if (found == state_.jobs_by_id.end()) return no_such_job(id);
  return found->second;
}

absl::StatusOr<FarmJob*> Scheduler::find_open_job(std::string_view id) {
  absl::StatusOr<FarmJob*> job = find_job(id);
  if (!job.ok() || (*job)->open()) return job;
  return absl::FailedPreconditionError(
      absl::StrCat("job ", (*job)->request.id, " ", past_tense((*job)->state)));
}

// ---------------------------------------------------------------- changes

absl::Status Scheduler::add_job(JobRequest request) {
  if (state_.jobs_by_id.contains(request.id))
    return absl::AlreadyExistsError(absl::StrCat("there is a job ", request.id));
  auto job = std::make_unique<FarmJob>(state_.jobs_added++, std::move(request));
  state_.jobs_by_id.emplace(job->request.id, job.get());
  steps_.open(*job);
  course_.await_others(*job);
  course_.take_turns(*job);
  state_.jobs_by_number.emplace(job->number, std::move(job));
  return absl::OkStatus();
}

absl::Status Scheduler::adopt(std::string_view id, const std::string& from,
                              const std::vector<AdoptedResult>& results) {
  const absl::StatusOr<FarmJob*> found = find_job(id);
  if (!found.ok()) return found.status();
  FarmJob& job = **found;
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
  classes_.bind(job, results.front().arithmetic_class);
  for (const AdoptedResult& result : results) {
    job.units.finish({.fingerprint = result.fingerprint,
                      .sequence = ++job.results,
                      .host = state_.number_of_host(result.host),
                      .units = result.units});
    job.hosts_with_results.insert(state_.number_of_host(result.host));
    classes_.note(job, result.host, job.results, result.arithmetic_class);
  }
  steps_.open(job);
  job.state = v1::RUNNING;
  job.adopted = job.units.done();
  job.adopted_from = from;
  FarmEvent& event = state_.record(FarmEvent::Kind::kAdopted, job.request.id);
  event.value = job.adopted;
  event.text = from;
  settle(job, Time{0});
  return absl::OkStatus();
}

absl::StatusOr<bool> Scheduler::cancel_job(std::string_view id) {
  const absl::StatusOr<FarmJob*> job = find_job(id);
  if (!job.ok()) return job.status();
  if (!(*job)->open()) return false;
  course_.end(**job, v1::CANCELLED, "");
  return true;
}

absl::Status Scheduler::pause_job(std::string_view id, bool paused) {
  const absl::StatusOr<FarmJob*> found = find_open_job(id);
  if (!found.ok()) return found.status();
  FarmJob& job = **found;
  if (job.paused == paused) return absl::OkStatus();
  job.paused = paused;
  course_.take_turns(job);
  state_.record(FarmEvent::Kind::kPaused, job.request.id).value = paused;
  return absl::OkStatus();
}

absl::Status Scheduler::set_priority(std::string_view id, std::int32_t priority) {
  const absl::StatusOr<FarmJob*> found = find_open_job(id);
  if (!found.ok()) return found.status();
  FarmJob& job = **found;
  if (job.request.priority == priority) return absl::OkStatus();
  job.request.priority = priority;
  course_.take_turns(job);
  state_.record(FarmEvent::Kind::kPriority, job.request.id).value = priority;
  return absl::OkStatus();
}

absl::Status Scheduler::retry_job(std::string_view id) {
  const absl::StatusOr<FarmJob*> found = find_job(id);
  if (!found.ok()) return found.status();
  FarmJob& job = **found;
  if (job.state == v1::DONE) return absl::OkStatus();
  if (!job.open() && job.state != v1::INCOMPLETE) {
    return absl::FailedPreconditionError(
        absl::StrCat("job ", job.request.id, " is over and not incomplete; submit it again"));
  }
  state_.record(FarmEvent::Kind::kReopened, job.request.id);
  const std::set<std::uint32_t> doubted = faults_.doubted(job);
  faults_.reopen(job);
  for (const std::uint32_t unit : doubted) {
    // Another one of them may have taken it along.
    if (job.units.state(unit) == UnitState::kDone) steps_.revoke(job, job.units.result(unit));
  }
  if (!doubted.empty()) {
    if (job.audits.empty()) state_.auditing.erase(job.number);
    state_.note(job, absl::StrCat("what phases made is made anew, for it could not be read: ", doubted.size(),
                                  " units"));
  }
  steps_.open(job);
  return absl::OkStatus();
}

absl::Status Scheduler::revoke_result(std::string_view id, std::uint32_t unit, std::uint64_t sequence,
                                      const std::string& why) {
  const absl::StatusOr<FarmJob*> found = find_job(id);
  if (!found.ok()) return found.status();
  FarmJob& job = **found;
  if (!job.open() && job.state != v1::DONE && job.state != v1::INCOMPLETE) {
    return absl::FailedPreconditionError(absl::StrCat("job ", job.request.id, " failed or was cancelled"));
  }
  if (unit >= job.units.count() || job.units.state(unit) != UnitState::kDone ||
      job.units.result(unit).sequence != sequence) {
    return absl::OkStatus();
  }
  if (!job.open()) {
    state_.record(FarmEvent::Kind::kReopened, job.request.id);
    faults_.reopen(job);
  }
  steps_.revoke(job, job.units.result(unit));
  if (job.audits.empty()) state_.auditing.erase(job.number);
  state_.note(job, absl::StrCat("unit ", unit, " is done again: ", why));
  return absl::OkStatus();
}

absl::Status Scheduler::forget_job(std::string_view id) {
  const absl::StatusOr<FarmJob*> job = find_job(id);
  if (!job.ok()) return job.status();
  if ((*job)->open())
    return absl::FailedPreconditionError(absl::StrCat("job ", std::string(id), " is not over"));
  course_.fail_awaiting((*job)->request.id, "was deleted");
  const std::uint64_t number = (*job)->number;
  state_.jobs_by_id.erase((*job)->request.id);
  state_.jobs_by_number.erase(number);
  return absl::OkStatus();
}

void Scheduler::settle(FarmJob& job, Time now) {
  audits_.release(job);
  if (!job.open() || !job.units.settled()) return;
  checks_.review(job, now);
  audits_.give_up(job);
  audits_.release(job);
  if (!job.audits.empty() || !job.spots.empty() || !job.units.settled()) return;
  if (const std::uint32_t unconfirmed = checks_.unconfirmed_units(job);
      unconfirmed != job.units_unconfirmed) {
    job.units_unconfirmed = unconfirmed;
    state_.record(FarmEvent::Kind::kUnconfirmed, job.request.id).value = unconfirmed;
  }
  if (job.units.done() == job.units.count()) return course_.end(job, v1::DONE, "");
  if (job.units.set_aside() == 0) return;
  // Units that never began because they wait for others, as those behind a phase do, may still work.
  const bool nothing = job.units.set_aside() == job.units.count() && !faults_.has_disputes(job);
  course_.end(job, nothing ? v1::FAILED : v1::INCOMPLETE, faults_.what_is_missing(job));
}

// ---------------------------------------------------------------- views

absl::StatusOr<JobView> Scheduler::job(std::string_view id) const {
  const absl::StatusOr<const FarmJob*> found = find_job(id);
  if (!found.ok()) return found.status();
  const FarmJob& job = **found;
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
               .units_unconfirmed = job.open() ? checks_.unconfirmed_units(job) : job.units_unconfirmed,
               .units_adopted = job.adopted,
               .adopted_from = job.adopted_from,
               .classes = job.classes.all(),
               .workers = static_cast<std::uint32_t>(job.holders.size()),
               .awaited = {job.awaited.begin(), job.awaited.end()}};
  if (!view.classes.empty()) view.isa = isas_of(view.classes);
  if (units.set_aside() == 0) return view;
  for (const auto& [unit, failures] : job.failures) {
    if (units.state(unit) == UnitState::kSetAside) view.set_aside.push_back({unit, failures});
  }
  std::sort(view.set_aside.begin(), view.set_aside.end(),
            [](const SetAsideView& a, const SetAsideView& b) { return a.unit < b.unit; });
  if (view.set_aside.size() > FarmState::kMaxListed) view.set_aside.resize(FarmState::kMaxListed);
  return view;
}

std::string Scheduler::waiting_for(std::string_view id, Time now) const {
  const absl::StatusOr<const FarmJob*> found = find_job(id);
  if (!found.ok() || !(*found)->open() || (*found)->leases > 0) return "";
  const FarmJob& job = **found;
  if (job.paused) return "the job is paused";
  if (!job.awaited.empty()) {
    const std::string& first = *job.awaited.begin();
    const bool incomplete = state_.jobs_by_id.at(first)->state == v1::INCOMPLETE;
    return absl::StrCat("job ", first, incomplete ? " is incomplete" : "",
                        incomplete ? ", and has to be retried and done first" : " has to be done first");
  }
  if (state_.workers.empty()) return "there is no worker";
  std::size_t with_tags = 0, with_isa = 0, free = 0;
  for (const auto& [name, worker] : state_.workers) {
    if (worker.draining || !trust_.trusts(worker.info.host)) continue;
    if (!has_tags(worker.info, job.request.required_tags)) continue;
    ++with_tags;
    if (classes_.class_for(worker, job) == nullptr) continue;
    ++with_isa;
    free += eligibility_.may_work_on(worker, job, now);
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
  if (classes_.settling(job, now))
    return "workers have only just come; it is bound to the class of most of them in a moment";
  if (free == 0) return "the job failed on every host that could take it; they are tried again later";
  return "other jobs go first, or the workers are still busy";
}

std::string Scheduler::left_out(std::string_view id) const {
  const absl::StatusOr<const FarmJob*> job = find_job(id);
  return job.ok() ? classes_.left_out(**job) : "";
}

std::vector<Lease> Scheduler::leases_of(std::string_view id) const {
  std::vector<Lease> leases;
  const absl::StatusOr<const Job*> job = find_job(id);
  if (!job.ok()) return leases;
  for (const LeaseId lease : state_.leases.of_job((*job)->number)) leases.push_back(state_.leases.get(lease));
  return leases;
}

}  // namespace tessera::server
