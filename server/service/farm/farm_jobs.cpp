// The calls by which clients handle jobs: look at them, change them, take their results.
#include <algorithm>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/str_cat.h"
#include "scheduler/identity.h"
#include "service/farm/farm.h"
#include "service/job/journal_events.h"
#include "telemetry/log.h"
#include "wire/limits.h"
#include "wire/tile_result.h"
#include "wire/version.h"

namespace tessera::server {
namespace {

// Upper bounds of one WatchJob message: enough to keep a connection busy, little enough to hold for a
// thousand slow readers.
constexpr std::size_t kWatchBatchBytes = std::size_t{1} << 20;
constexpr std::size_t kWatchBatchResults = 256;
// Upper bound of the workers in one answer. Twenty thousand with the longest names that are taken go into it.
constexpr std::size_t kMostWorkerBytes = wire::kMaxMessageBytes / 2;

/// DataLoss also for a payload that can be read, but is not what was written: it has a checksum of its own.
absl::StatusOr<std::string> read_result(Journal& journal, const std::string& job, std::uint64_t sequence) {
  absl::StatusOr<std::string> payload = journal.read_result(job, sequence);
  absl::Status status = payload.ok() ? wire::decode_tile_result(*payload).status() : payload.status();
  if (status.ok()) return payload;
  if (absl::IsInvalidArgument(status) || absl::IsNotFound(status))
    status = absl::DataLossError(status.message());
  return absl::Status(
      status.code(), absl::StrCat("result ", sequence, " of job ", job, ": ", std::string(status.message())));
}

/// Who works on the job.
void add_workers(const Scheduler& scheduler, const std::string& id, v1::GetJobResponse& response) {
  absl::flat_hash_map<std::string, std::uint32_t> leases;
  for (const Assignment& assignment : scheduler.assignments()) {
    if (assignment.job == id) leases[assignment.worker] = assignment.leases;
  }
  for (const WorkerView& view : scheduler.workers()) {
    const auto found = leases.find(view.info.id);
    if (found == leases.end()) continue;
    v1::JobWorker& worker = *response.add_workers();
    worker.set_name(view.info.name);
    worker.set_host(short_name(view.info.host));
    worker.set_leases(found->second);
  }
}

}  // namespace

// ---------------------------------------------------------------- looking and cancelling

absl::StatusOr<v1::GetJobResponse> Farm::get_job(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const absl::StatusOr<JobEntry*> entry = find_job(id);
  if (!entry.ok()) return entry.status();
  v1::GetJobResponse response;
  *response.mutable_status() = describe(**entry);
  add_failure_logs(**entry, view_of(**entry), *response.mutable_status());
  *response.mutable_spec() = (*entry)->shape->spec;
  for (const HostShare& slow : (*entry)->hosts.slow()) {
    v1::SlowHost& host = *response.add_slow_hosts();
    host.set_host(short_name(slow.host));
    host.set_units(slow.timed_units);
    host.set_slowness(slow.slowness);
  }
  add_workers(scheduler_, id, response);
  return response;
}

v1::ListJobsResponse Farm::list_jobs() {
  const std::lock_guard lock(mutex_);
  v1::ListJobsResponse response;
  for (const auto& entry : jobs_.all()) {
    v1::JobStatus& status = *response.add_jobs() = outline(*entry);
    status.clear_set_aside();
    status.clear_latest_failures();
  }
  return response;
}

absl::StatusOr<std::string> Farm::owner_of(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const absl::StatusOr<JobEntry*> entry = find_job(id);
  if (!entry.ok()) return entry.status();
  return (*entry)->shape->spec.farm().user();
}

v1::JobStatus Farm::outline(const JobEntry& entry) const {
  v1::JobStatus status = status_of(entry, view_of(entry));
  const std::int64_t end = entry.finished_unix_ms != 0 ? entry.finished_unix_ms : unix_now();
  status.set_elapsed_ms(std::max<std::int64_t>(end - entry.submitted_unix_ms, 0));
  if (is_open(status.state()) && !status.paused()) {
    const std::uint32_t left = status.units_total() - status.units_done() - status.units_set_aside();
    if (const auto time = entry.rate.time_for(left, now())) status.set_left_ms(time->count());
  }
  return status;
}

v1::JobStatus Farm::describe(const JobEntry& entry) const {
  v1::JobStatus status = outline(entry);
  if (!entry.past) status.set_waiting_for(scheduler_.waiting_for(entry.id, now()));
  if (!entry.past) status.set_left_out(scheduler_.left_out(entry.id));
  if (is_open(status.state())) return status;
  for (const std::string& host : entry.hosts.hosts()) {
    if (scheduler_.trusts(host)) continue;
    status.add_notes(
        absl::StrCat(entry.hosts.units_of(host), " units are of host ", short_name(host),
                     ", which returned wrong pixels and is in quarantine: they may be wrong too; ",
                     "tessera submit --fresh renders all again"));
  }
  return status;
}

// ---------------------------------------------------------------- changes

void Farm::answer_with_status(const absl::Status& changed, const std::string& id, Done<v1::JobStatus> done) {
  if (!changed.ok()) return done(changed);
  commit({}, {}, /*wait=*/true, [this, id, done = std::move(done)](const absl::Status& status) {
    if (!status.ok()) return done(status);
    absl::StatusOr<v1::GetJobResponse> job = get_job(id);
    job.ok() ? done(std::move(*job->mutable_status())) : done(job.status());
  });
  dispatcher_.notify_work();
}

void Farm::cancel(const std::string& id, Done<v1::JobStatus> done) {
  if (absl::Status status = check_serving(); !status.ok()) return done(std::move(status));
  const std::lock_guard lock(mutex_);
  const absl::StatusOr<JobEntry*> entry = find_job(id);
  if (!entry.ok()) return done(entry.status());
  answer_with_status((*entry)->past ? absl::OkStatus() : scheduler_.cancel_job(id).status(), id,
                     std::move(done));
}

void Farm::delete_job(const std::string& id, DoneEmpty done) {
  if (absl::Status status = check_serving(); !status.ok()) return done(std::move(status));
  const std::lock_guard lock(mutex_);
  const absl::StatusOr<JobEntry*> entry = find_job(id);
  if (!entry.ok()) return done(entry.status());
  if (!(*entry)->durable_end) {
    return done(absl::FailedPreconditionError(absl::StrCat("job ", id, " is not over: cancel it first")));
  }
  telemetry::log(spdlog::level::info, {.job = id, .user = (*entry)->shape->spec.farm().user()},
                 "job {} is deleted on request", id);
  forget(id, std::move(done));
}

void Farm::forget(const std::string& id, DoneEmpty done) {
  const JobEntry& entry = *jobs_.find(id);
  if (!entry.past) static_cast<void>(scheduler_.forget_job(id));
  jobs_.erase(id);
  keeper_.forget(id);
  commit({JobPruned{.id = id}}, {}, /*wait=*/true, std::move(done));
}

absl::Status Farm::check_reopening(const JobEntry& entry, const Caller& by) const {
  if (!by.has_quotas()) return absl::OkStatus();
  const std::string& user = entry.shape->spec.farm().user();
  if (absl::Status s = options_.quotas.check_priority(by.user, view_of(entry).priority); !s.ok()) return s;
  UserShare share = share_of(user);
  ++share.open_jobs;
  return options_.quotas.check_share(user, share);
}

void Farm::retry(const std::string& id, Done<v1::JobStatus> done, const Caller& by) {
  if (absl::Status status = check_serving(); !status.ok()) return done(std::move(status));
  const std::lock_guard lock(mutex_);
  const absl::StatusOr<JobEntry*> entry = find_job(id);
  if (!entry.ok()) return done(entry.status());
  if ((*entry)->past) {
    const bool is_done = (*entry)->past->state == v1::DONE;
    const absl::Status over =
        absl::FailedPreconditionError(absl::StrCat("job ", id, " is over and not incomplete"));
    return answer_with_status(is_done ? absl::OkStatus() : over, id, std::move(done));
  }
  absl::Status status = absl::OkStatus();
  if (scheduler_.job(id)->state == v1::INCOMPLETE) status = check_reopening(**entry, by);
  if (status.ok()) status = scheduler_.retry_job(id);
  answer_with_status(status, id, std::move(done));
}

void Farm::adjust(const v1::AdjustJobRequest& request, Done<v1::JobStatus> done, const Caller& by) {
  if (absl::Status status = check_serving(); !status.ok()) return done(std::move(status));
  const std::lock_guard lock(mutex_);
  const std::string& id = request.job_id();
  const absl::StatusOr<JobEntry*> entry = find_job(id);
  if (!entry.ok()) return done(entry.status());
  absl::Status status =
      (*entry)->past ? absl::FailedPreconditionError(absl::StrCat("job ", id, " is over")) : absl::OkStatus();
  if (status.ok() && request.has_priority() && by.has_quotas())
    status = options_.quotas.check_priority(by.user, request.priority());
  if (status.ok() && request.has_paused()) status = scheduler_.pause_job(id, request.paused());
  if (status.ok() && request.has_priority()) status = scheduler_.set_priority(id, request.priority());
  answer_with_status(status, id, std::move(done));
}

void Farm::trust_host(const std::string& host, DoneEmpty done) {
  if (absl::Status status = check_serving(); !status.ok()) return done(std::move(status));
  const std::lock_guard lock(mutex_);
  if (absl::Status status = scheduler_.trust_host(host); !status.ok()) return done(std::move(status));
  commit({}, {}, /*wait=*/true, std::move(done));
  dispatcher_.notify_work();
}

void Farm::note_fetched(const std::string& id) {
  const std::lock_guard lock(mutex_);
  JobEntry* const entry = jobs_.find(id);
  if (entry == nullptr || entry->fetched || !entry->durable_end) return;
  entry->fetched = true;
  commit({JobFetched{.id = id}}, {}, /*wait=*/true, [](const absl::Status&) {});
}

// ---------------------------------------------------------------- workers, as clients see them

v1::ListWorkersResponse Farm::list_workers() {
  const std::lock_guard lock(mutex_);
  const Time at = now();
  v1::ListWorkersResponse response;
  response.set_build(wire::build_version());
  response.set_unix_time_ms(unix_now());
  std::size_t bytes = 0;
  absl::flat_hash_map<std::string, std::vector<Assignment>> assignments;
  for (Assignment& assignment : scheduler_.assignments())
    assignments[assignment.worker].push_back(std::move(assignment));
  for (const WorkerView& view : scheduler_.workers()) {
    if (bytes > kMostWorkerBytes) {
      spdlog::warn("the list of workers is cut: {} of them fill a message", response.workers_size());
      break;
    }
    v1::WorkerStatus& worker = *response.add_workers();
    worker.set_worker_id(view.info.id);
    worker.set_name(view.info.name);
    worker.set_isa(view.info.isa);
    worker.set_build(view.info.build);
    worker.set_threads(view.info.threads);
    worker.set_leases(view.leases);
    worker.set_units_done(view.units_done);
    worker.set_draining(view.draining);
    worker.set_last_seen_ms_ago((at - view.last_seen).count());
    worker.set_host(short_name(view.info.host));
    for (const std::string& tag : view.info.tags) worker.add_tags(tag);
    worker.set_quarantine(view.quarantine);
    worker.set_slowness(view.slowness);
    worker.set_certificate(view.info.certificate);
    if (const auto known = registrations_by_worker_.find(view.info.id);
        known != registrations_by_worker_.end()) {
      worker.set_failures(known->second.failures);
      worker.set_resident_bytes(known->second.resident_bytes);
    }
    for (const Assignment& assignment : assignments[view.info.id]) {
      const v1::JobSpec& spec = jobs_.find(assignment.job)->shape->spec;
      v1::WorkerJob& job = *worker.add_jobs();
      job.set_job_id(assignment.job);
      job.set_name(spec.farm().name());
      job.set_user(spec.farm().user());
      job.set_leases(assignment.leases);
    }
    v1::WorkerArithmetic& arithmetic = *worker.mutable_arithmetic();
    for (const std::string& name : view.info.classes) arithmetic.add_classes(name);
    for (const std::string& job : view.closed_jobs) arithmetic.add_closed_jobs(job);
    bytes += worker.ByteSizeLong();
  }
  return response;
}

// ---------------------------------------------------------------- results

absl::StatusOr<WatchBatch> Farm::next_results(const std::string& id, std::uint64_t after, bool status_only) {
  WatchBatch batch{.response = {}, .last = after};
  std::shared_ptr<const JobShape> shape;
  std::vector<CoveredUnits> units;
  std::vector<std::uint64_t> revoked;
  bool ended, past;
  std::uint64_t available;
  {
    const std::lock_guard lock(mutex_);
    const absl::StatusOr<JobEntry*> found = find_job(id);
    if (!found.ok()) return found.status();
    const JobEntry& entry = **found;
    *batch.response.mutable_status() = describe(entry);
    shape = entry.shape;
    available = entry.durable_results;
    ended = entry.durable_end && (entry.past || available == entry.units_by_sequence.size());
    past = entry.past.has_value();
    revoked = entry.past_revoked;
    if (!status_only && !past && after < available) {
      const auto first = entry.units_by_sequence.begin() + static_cast<std::ptrdiff_t>(after);
      units.assign(first, first + static_cast<std::ptrdiff_t>(
                                      std::min<std::uint64_t>(available - after, kWatchBatchResults)));
    }
  }
  if (past && !status_only && after < available) {
    absl::StatusOr<std::vector<CoveredUnits>> read = journal_.read_units(id, after, kWatchBatchResults);
    if (!read.ok()) return read.status();
    units = *std::move(read);
  }
  std::size_t bytes = 0;
  for (const CoveredUnits& covered : units) {
    if (covered.first == JobEntry::kRevoked || !shape->plan->is_of_picture(covered.first) ||
        std::binary_search(revoked.begin(), revoked.end(), batch.last + 1)) {
      ++batch.last;
      continue;
    }
    const absl::StatusOr<std::string> payload = read_result(journal_, id, batch.last + 1);
    if (absl::IsDataLoss(payload.status())) {
      const std::lock_guard lock(mutex_);
      const absl::StatusOr<JobEntry*> found = find_job(id);
      if (!found.ok()) return found.status();
      if (absl::Status status = do_again(**found, batch.last + 1, payload.status()); !status.ok())
        return status;
      ended = false;
      break;
    }
    if (!payload.ok()) return payload.status();
    if (bytes > 0 && bytes + payload->size() > kWatchBatchBytes) break;
    bytes += payload->size();
    v1::UnitResult& result = *batch.response.add_results();
    result.set_sequence(++batch.last);
    // A journal may be damaged.
    const std::optional<UnitRun> run = shape->plan->run(covered.first, covered.ranges);
    if (!run)
      return absl::DataLossError(
          absl::StrCat("journal: job ", id, ": result ", batch.last, " cannot be read"));
    *result.mutable_unit() = shape->plan->unit(*run);
    result.set_ranges(run->count);
    result.set_payload(*payload);
  }
  batch.finished = ended && (status_only || batch.last >= available);
  return batch;
}

absl::Status Farm::do_again(JobEntry& entry, std::uint64_t sequence, const absl::Status& damage) {
  if (entry.past) {
    if (entry.past->state != v1::DONE) return damage;
    // It is over for so long that the scheduler does not know it any more.
    const absl::StatusOr<JobRecord> record = journal_.read_job(entry.id);
    if (!record.ok()) return record.status();
    if (absl::Status status = restore_job(scheduler_, request_of(entry), *record); !status.ok())
      return status;
    recall(entry, *record);
  }
  const std::uint32_t unit = entry.units_by_sequence[sequence - 1].first;
  if (unit == JobEntry::kRevoked) return absl::OkStatus();  // somebody else noticed before
  absl::Status status = scheduler_.revoke_result(entry.id, unit, sequence, std::string(damage.message()));
  commit({}, {}, /*wait=*/false, [](const absl::Status&) {});
  dispatcher_.notify_work();
  return absl::IsFailedPrecondition(status) ? damage : status;
}

// ---------------------------------------------------------------- retention

/// Drops what is kept of the units of jobs that ended a while ago. An incomplete job may go on. With mutex_
/// held.
void Farm::retire_jobs() {
  keeper_.live_on();
  for (const auto& entry : jobs_.all()) {
    if (entry->past || !entry->durable_end || entry->durable_results < entry->units_by_sequence.size() ||
        keeper_.since_end_of(entry->id) < options_.late_results) {
      continue;
    }
    JobView view = view_of(*entry);
    if (view.state == v1::INCOMPLETE || !scheduler_.forget_job(entry->id).ok()) continue;
    retire(*entry, std::move(view));
  }
}

void Farm::drop_lease_uploads() {
  std::vector<std::string> old = lease_uploads_.take_old(clock_.now());
  std::erase_if(old, [this](const std::string& digest) {
    return jobs_.blobs().size_of(digest).has_value() ||
           std::ranges::any_of(jobs_.all(), [&](const std::unique_ptr<JobEntry>& entry) {
             return entry->phase_blobs.has(digest);
           });
  });
  keeper_.drop_unused(std::move(old), LeaseUploads::kKept);
}

/// Deletes jobs whose time is over. With mutex_ held.
void Farm::prune() {
  const std::vector<std::string> old =
      keeper_.old_jobs(jobs_, [this](const JobEntry& entry) { return view_of(entry).state; });
  for (const std::string& id : old) {
    telemetry::log(spdlog::level::info, {.job = id}, "job {} is deleted: its time is over", id);
    forget(id, [](const absl::Status&) {});
  }
  drop_lease_uploads();
  keeper_.clean_up(jobs_, !old.empty());
}

}  // namespace tessera::server
