// Jobs and their clients. What workers call is in farm_workers.cpp.
#include "service/farm.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "service/identifier.h"
#include "service/result_check.h"
#include "wire/limits.h"

namespace tessera::server {
namespace {

// Of one WatchJob message: enough to keep a connection busy, little enough to hold for a slow reader.
constexpr std::size_t kWatchBatchBytes = std::size_t{4} << 20;
constexpr std::size_t kWatchBatchResults = 256;

std::int64_t unix_milliseconds() {
  using namespace std::chrono;
  return duration_cast<milliseconds>(system_clock::now().time_since_epoch()).count();
}

}  // namespace

Farm::Farm(Journal& journal, BlobStore& blobs, const FarmOptions& options, std::function<void(absl::Status)> on_failure)
    : journal_(journal),
      blobs_(blobs),
      options_(options),
      on_failure_(std::move(on_failure)),
      scheduler_({.lease_timeout = options.lease_timeout, .epoch = journal.epoch()}),
      dispatcher_([this] { expire(); }),
      commits_(journal) {}

absl::StatusOr<std::unique_ptr<Farm>> Farm::open(Journal& journal, BlobStore& blobs, const FarmOptions& options,
                                                 std::function<void(absl::Status)> on_failure) {
  std::unique_ptr<Farm> farm(new Farm(journal, blobs, options, std::move(on_failure)));
  const absl::Status status = journal.recover([&](JobRecord record) { return farm->recover(std::move(record)); });
  if (!status.ok()) return status;
  return farm;
}

Farm::~Farm() { stop(); }

void Farm::stop() {
  stopping_ = true;
  dispatcher_.stop();
}

absl::Status Farm::recover(JobRecord record) {
  absl::StatusOr<JobEntry> made = entry_of(record);
  if (!made.ok()) return made.status();
  const std::lock_guard lock(mutex_);
  JobEntry& entry = jobs_.add(*std::move(made));
  if (entry.past) return absl::OkStatus();

  const v1::JobSpec& spec = entry.shape->spec;
  absl::Status status = scheduler_.add_job({.id = entry.id,
                                            .plan = entry.shape->plan,
                                            .scene_digest = spec.scene().digest(),
                                            .isa = record.isa.empty() ? spec.isa() : record.isa,
                                            .priority = spec.priority(),
                                            .generation = entry.generation});
  for (const JobRecord::Result& result : record.results) {
    status.Update(scheduler_.restore_done(entry.id, result.unit, fingerprint_of(result.digest)));
  }
  spdlog::info("job {} goes on with {} of {} units done", entry.id, record.results.size(),
               entry.shape->plan->unit_count());
  return status;
}

Time Farm::now() const { return std::chrono::duration_cast<Time>(std::chrono::steady_clock::now().time_since_epoch()); }

absl::Status Farm::check_serving() const {
  return stopping_ ? absl::UnavailableError("the coordinator is shutting down") : absl::OkStatus();
}

absl::StatusOr<JobEntry*> Farm::find_job(const std::string& id) {
  JobEntry* const entry = jobs_.find(id);
  if (entry == nullptr) return absl::NotFoundError(absl::StrCat("there is no job ", id));
  return entry;
}

JobView Farm::view_of(const JobEntry& entry) const { return entry.past ? *entry.past : *scheduler_.job(entry.id); }

void Farm::commit(std::vector<JournalEntry> entries, const Shown& shown, DoneEmpty done) {
  commits_.push(std::move(entries), [this, shown, done = std::move(done)](const absl::Status& status) {
    if (!status.ok()) {
      if (!failed_.exchange(true)) {
        spdlog::critical("the journal cannot be written, so nothing more is acknowledged: {}", status.ToString());
        on_failure_(status);
      }
      done(absl::UnavailableError("the coordinator cannot write its journal"));
      return;
    }
    if (shown.entry != nullptr) {
      const std::lock_guard lock(mutex_);
      shown.entry->durable_results = std::max(shown.entry->durable_results, shown.results);
      shown.entry->durable_end |= shown.end;
    }
    dispatcher_.notify_news();
    done(absl::OkStatus());
  });
}

// ---------------------------------------------------------------- submission

absl::Status Farm::check_blobs(const v1::JobSpec& spec) const {
  std::size_t missing = 0;
  const v1::BlobRef* first = nullptr;
  const auto look_for = [&](const v1::BlobRef& blob) {
    if (blobs_.query(blob.digest()).complete) return;
    if (missing++ == 0) first = &blob;
  };
  look_for(spec.scene());
  for (const v1::BlobRef& blob : spec.blobs()) look_for(blob);
  if (missing == 0) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(missing, " blobs are missing; upload them first. One is ",
                                                    first->digest(), " (", first->path(), ")"));
}

std::uint64_t Farm::claim_uploads(const v1::JobSpec& spec) {
  std::uint64_t bytes = 0;
  const auto claim = [&](const v1::BlobRef& blob) {
    if (const auto found = unclaimed_uploads_.find(blob.digest()); found != unclaimed_uploads_.end()) {
      bytes += found->second;
      unclaimed_uploads_.erase(found);
    }
  };
  claim(spec.scene());
  for (const v1::BlobRef& blob : spec.blobs()) claim(blob);
  return bytes;
}

void Farm::note_upload(const std::string& digest, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  unclaimed_uploads_[digest] += bytes;
}

void Farm::submit(const v1::SubmitJobRequest& request, Done<std::string> done) {
  if (absl::Status status = check_serving(); !status.ok()) return done(std::move(status));
  if (request.request_id().empty() || request.request_id().size() > wire::kMaxTextBytes) {
    return done(absl::InvalidArgumentError("request_id is empty or too long"));
  }
  auto shape = JobShape::make(request.spec());
  if (!shape.ok()) return done(shape.status());
  if (absl::Status status = check_blobs(request.spec()); !status.ok()) return done(std::move(status));

  std::unique_lock lock(mutex_);
  if (const JobEntry* const known = jobs_.find_request(request.request_id())) {
    // Sent a second time: the answer is the same, once the first is durable.
    return commit({}, {}, [id = known->id, done = std::move(done)](const absl::Status& status) {
      status.ok() ? done(id) : done(status);
    });
  }
  const v1::JobSpec& spec = (*shape)->spec;
  std::string id = random_identifier(8);
  while (jobs_.find(id) != nullptr) id = random_identifier(8);
  JobEntry& entry = jobs_.add({.id = id,
                               .request_id = request.request_id(),
                               .shape = *shape,
                               .submitted_unix_ms = unix_milliseconds(),
                               .uploaded_bytes = claim_uploads(spec),
                               .past = std::nullopt,
                               .stats = {},
                               .units_by_sequence = {}});
  absl::Status status = scheduler_.add_job({.id = id,
                                            .plan = entry.shape->plan,
                                            .scene_digest = spec.scene().digest(),
                                            .isa = spec.isa(),
                                            .priority = spec.priority(),
                                            .generation = entry.generation});
  if (!status.ok()) return done(std::move(status));
  spdlog::info("job {} \"{}\": {} x {} pixels, {} samples, {} units", id, spec.name(), spec.width(), spec.height(),
               spec.settings().spp(), entry.shape->plan->unit_count());
  // Workers may begin at once: their results are journaled after the job.
  commit({JobAdded{.id = id,
                   .request_id = entry.request_id,
                   .spec = spec.SerializeAsString(),
                   .generation = entry.generation,
                   .submitted_unix_ms = entry.submitted_unix_ms,
                   .uploaded_bytes = entry.uploaded_bytes}},
         {},
         [id, done = std::move(done)](const absl::Status& committed) { committed.ok() ? done(id) : done(committed); });
  lock.unlock();
  dispatcher_.notify_work();
}

// ---------------------------------------------------------------- looking and cancelling

absl::StatusOr<v1::GetJobResponse> Farm::get_job(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const absl::StatusOr<JobEntry*> entry = find_job(id);
  if (!entry.ok()) return entry.status();
  v1::GetJobResponse response;
  *response.mutable_status() = status_of(**entry, view_of(**entry));
  *response.mutable_spec() = (*entry)->shape->spec;
  return response;
}

v1::ListJobsResponse Farm::list_jobs() {
  const std::lock_guard lock(mutex_);
  v1::ListJobsResponse response;
  for (const auto& entry : jobs_.all()) *response.add_jobs() = status_of(*entry, view_of(*entry));
  return response;
}

JobEnded Farm::end_job(JobEntry& entry) {
  const JobView view = view_of(entry);
  entry.finished_unix_ms = unix_milliseconds();
  spdlog::info("job {} {}{}{}", entry.id, v1::JobState_Name(view.state), view.error.empty() ? "" : ": ", view.error);
  return {.id = entry.id, .state = view.state, .error = view.error, .finished_unix_ms = entry.finished_unix_ms};
}

void Farm::cancel(const std::string& id, Done<v1::JobStatus> done) {
  if (absl::Status status = check_serving(); !status.ok()) return done(std::move(status));
  const std::lock_guard lock(mutex_);
  const absl::StatusOr<JobEntry*> entry = find_job(id);
  if (!entry.ok()) return done(entry.status());
  const bool ended = !(*entry)->past && *scheduler_.cancel_job(id);
  std::vector<JournalEntry> entries;
  if (ended) entries.push_back(end_job(**entry));
  v1::JobStatus now_is = status_of(**entry, view_of(**entry));
  commit(std::move(entries), {.entry = *entry, .end = ended},
         [now_is = std::move(now_is), done = std::move(done)](const absl::Status& status) {
           status.ok() ? done(now_is) : done(status);
         });
}

v1::ListWorkersResponse Farm::list_workers() {
  const std::lock_guard lock(mutex_);
  const Time at = now();
  v1::ListWorkersResponse response;
  for (const WorkerView& view : scheduler_.workers()) {
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
  }
  return response;
}

absl::StatusOr<WatchBatch> Farm::next_results(const std::string& id, std::uint64_t after, bool status_only) {
  WatchBatch batch{.response = {}, .last = after};
  std::shared_ptr<const JobShape> shape;
  std::vector<std::uint32_t> units;
  bool ended;
  std::uint64_t available;
  {
    const std::lock_guard lock(mutex_);
    const absl::StatusOr<JobEntry*> found = find_job(id);
    if (!found.ok()) return found.status();
    const JobEntry& entry = **found;
    *batch.response.mutable_status() = status_of(entry, view_of(entry));
    shape = entry.shape;
    available = entry.durable_results;
    ended = entry.durable_end && available == entry.units_by_sequence.size();
    if (!status_only && after < available) {
      const auto first = entry.units_by_sequence.begin() + static_cast<std::ptrdiff_t>(after);
      units.assign(first,
                   first + static_cast<std::ptrdiff_t>(std::min<std::uint64_t>(available - after, kWatchBatchResults)));
    }
  }
  std::size_t bytes = 0;
  for (const std::uint32_t unit : units) {
    absl::StatusOr<std::string> payload = journal_.read_result(id, batch.last + 1);
    if (!payload.ok()) return payload.status();
    if (bytes > 0 && bytes + payload->size() > kWatchBatchBytes) break;
    bytes += payload->size();
    v1::UnitResult& result = *batch.response.add_results();
    result.set_sequence(++batch.last);
    *result.mutable_unit() = shape->plan->unit(unit);
    result.set_payload(*std::move(payload));
  }
  batch.finished = ended && (status_only || batch.last >= available);
  return batch;
}

}  // namespace tessera::server
