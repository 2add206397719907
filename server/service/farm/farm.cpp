// Opening and journaling. Submission is in farm_submission.cpp, what clients do with jobs in farm_jobs.cpp,
// what workers call in farm_workers.cpp and farm_results.cpp.
#include "service/farm/farm.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "scheduler/identity.h"
#include "service/job/journal_events.h"
#include "telemetry/log.h"

namespace tessera::server {
namespace {

telemetry::LogFields fields_of(const JobEntry& entry) {
  return {.job = entry.id, .user = entry.shape->spec.farm().user()};
}

/// For who watches the job.
void note_failure(JobEntry& entry, const FarmEvent& event) {
  ++entry.failures;
  const bool run_lost = event.kind == FarmEvent::Kind::kRunLost,
             run_failed = event.kind == FarmEvent::Kind::kRunFailed, is_run = run_lost || run_failed;
  JobEntry::NotedFailure& noted = entry.noted_failures.emplace_back();
  noted.grant = is_run ? 0 : event.value;
  noted.failed.set_unit_index(event.unit);
  if (is_run) noted.failed.set_ranges(static_cast<std::uint32_t>(event.value));
  v1::UnitFailure& failure = *noted.failed.mutable_failure();
  failure.set_host(short_name(event.host));
  failure.set_message(event.text);
  failure.set_lost(run_lost || event.kind == FarmEvent::Kind::kUnitLost);
  *failure.mutable_log() = {event.log.begin(), event.log.end()};
  if (entry.noted_failures.size() > JobEntry::kNotedFailures) entry.noted_failures.pop_front();
}

}  // namespace

Farm::Farm(Journal& journal, BlobStore& blobs, const FarmOptions& options,
           std::function<void(absl::Status)> on_failure)
    : journal_(journal),
      blobs_(blobs),
      options_(options),
      clock_(*options.clock),
      on_failure_(std::move(on_failure)),
      seal_(options.seal),
      scheduler_({.heartbeat_interval = options.heartbeat_interval,
                  .lease_timeout = options.lease_timeout,
                  .longest_run = options.longest_run,
                  .order = options.order,
                  .epoch = journal.epoch(),
                  .unconfirmed_share = options.unconfirmed_share,
                  .audit_key = seal_->derive_key("audits"),
                  .settle = options.settle,
                  .classes = options.classes,
                  .class_patience = options.class_patience}),
      uploads_(options.retention.blobs),
      keeper_(options.retention, blobs, clock_, options.lived_time),
      dispatcher_(clock_, [this] { tick(); }),
      commits_(journal) {}

absl::StatusOr<std::unique_ptr<Farm>> Farm::open(Journal& journal, BlobStore& blobs,
                                                 const FarmOptions& options,
                                                 std::function<void(absl::Status)> on_failure) {
  std::unique_ptr<Farm> farm(new Farm(journal, blobs, options, std::move(on_failure)));
  // Until all is recovered no tick may come between: by half of the jobs it would judge which blobs nobody
  // needs.
  const std::lock_guard lock(farm->mutex_);
  absl::Status status = restore_farm(farm->scheduler_, journal);
  status.Update(journal.recover([&](JobRecord record) { return farm->recover(std::move(record)); }));
  if (!status.ok()) return status;
  farm->commit({}, {}, /*wait=*/false, [](const absl::Status&) {});
  return farm;
}

Farm::~Farm() { stop(); }

void Farm::stop() {
  if (stopping_.exchange(true)) return dispatcher_.stop();
  dispatcher_.stop();
  const std::lock_guard lock(mutex_);
  keeper_.stop();
}

absl::Status Farm::recover(JobRecord record) {
  absl::StatusOr<JobEntry> made = entry_of(record);
  if (!made.ok()) return made.status();
  std::vector<std::uint64_t> sizes;
  for (const v1::BlobRef& blob : made->shape->spec.farm().blobs()) {
    const std::optional<std::uint64_t> known = jobs_.blobs().size_of(blob.digest());
    sizes.push_back(known ? *known : blobs_.query(blob.digest()).stored_bytes);
  }
  JobEntry& entry = jobs_.add(*std::move(made), sizes);
  if (entry.past) {
    if (record.whole_results < record.result_count) {
      telemetry::log(spdlog::level::err, fields_of(entry),
                     "job {}: its result file is missing or too short; {}", entry.id,
                     entry.past->state == v1::DONE ? "what is lost is rendered again when somebody fetches it"
                                                   : "what is lost cannot be fetched");
    }
    return absl::OkStatus();
  }

  absl::Status status = restore_job(scheduler_, request_of(entry), record);
  if (record.whole_results < record.result_count) {
    telemetry::log(spdlog::level::err, fields_of(entry),
                   "job {}: {} results are lost, for their file is too short; their units are done again",
                   entry.id, record.result_count - record.whole_results);
  }
  for (std::uint64_t sequence = record.whole_results + 1; status.ok() && sequence <= record.result_count;
       ++sequence) {
    status.Update(do_again(entry, sequence, absl::DataLossError("its result is not on the disk any more")));
  }
  telemetry::log(spdlog::level::info, fields_of(entry), "job {} goes on with {} of {} units done", entry.id,
                 scheduler_.job(entry.id)->units_done, entry.shape->plan->unit_count());
  return status;
}

Time Farm::now() const { return std::chrono::duration_cast<Time>(clock_.now().time_since_epoch()); }

absl::Status Farm::check_serving() const {
  return stopping_ ? absl::UnavailableError("the coordinator is shutting down") : absl::OkStatus();
}

absl::StatusOr<JobEntry*> Farm::find_job(const std::string& id) {
  JobEntry* const entry = jobs_.find(id);
  if (entry == nullptr) return absl::NotFoundError(absl::StrCat("there is no job ", id));
  return entry;
}

JobView Farm::view_of(const JobEntry& entry) const {
  return entry.past ? *entry.past : *scheduler_.job(entry.id);
}

void Farm::note_event(const FarmEvent& event, std::vector<Shown>& shown) {
  if (event.kind == FarmEvent::Kind::kDistrusted) {
    telemetry::log(spdlog::level::err, {.host = event.host}, "host {} is in quarantine: {}",
                   short_name(event.host), event.text);
    for (const auto& entry : jobs_.all()) note_distrusted(*entry, event.host);
  }
  JobEntry* const entry = event.job.empty() ? nullptr : jobs_.find(event.job);
  if (entry == nullptr) return;
  switch (event.kind) {
    case FarmEvent::Kind::kEnded:
      entry->finished_unix_ms = unix_now();
      shown.push_back({.job = event.job, .results = 0, .end = true, .times_reopened = entry->times_reopened});
      telemetry::log(spdlog::level::info, fields_of(*entry), "job {} {}{}{}", event.job,
                     v1::JobState_Name(static_cast<v1::JobState>(event.value)),
                     event.text.empty() ? "" : ": ", event.text);
      return;
    case FarmEvent::Kind::kBound:
      ++entry->bounds_under_way;
      shown.push_back({.job = event.job, .bound_to_class = true});
      return;
    case FarmEvent::Kind::kReopened:
      entry->durable_end = false;
      ++entry->times_reopened;
      entry->finished_unix_ms = 0;
      entry->fetched = false;
      return;
    case FarmEvent::Kind::kUnitFailed:
    case FarmEvent::Kind::kSceneFault:
    case FarmEvent::Kind::kUnitLost:
    case FarmEvent::Kind::kInputsFailed:
    case FarmEvent::Kind::kDisputed:
    case FarmEvent::Kind::kRunFailed:
    case FarmEvent::Kind::kRunLost:
      note_failure(*entry, event);
      return;
    case FarmEvent::Kind::kRevoked: {
      CoveredUnits& units = entry->units_by_sequence[static_cast<std::size_t>(event.value) - 1];
      units.first = JobEntry::kRevoked;
      entry->hosts.discount(event.host, units.ranges);
      return;
    }
    case FarmEvent::Kind::kNote:
      telemetry::log(spdlog::level::warn, fields_of(*entry), "job {}: {}", event.job, event.text);
      return;
    default:
      return;
  }
}

void Farm::note_distrusted(const JobEntry& entry, const std::string& subject) {
  std::uint32_t units = 0;
  for (const std::string& host : entry.hosts.hosts())
    units += covers(subject, host) ? entry.hosts.units_of(host) : 0;
  if (units == 0) return;
  // All results of an open job are revoked, and rendered again.
  if (!entry.past && is_open(scheduler_.job(entry.id)->state)) return;
  telemetry::log(spdlog::level::err,
                 {.job = entry.id, .host = subject, .user = entry.shape->spec.farm().user()},
                 "job {} is over, and {} of its units are of host {}", entry.id, units, short_name(subject));
}

void Farm::show(const std::vector<Shown>& shown) {
  std::vector<std::pair<v1::JobStatus, std::string>> ended;
  {
    const std::lock_guard lock(mutex_);
    for (const Shown& news : shown) {
      JobEntry* const entry = jobs_.find(news.job);
      if (entry == nullptr) continue;
      note_durable(*entry, news.results);
      entry->bounds_under_way -= news.bound_to_class;
      if (!news.end || news.times_reopened != entry->times_reopened) continue;
      entry->durable_end = true;
      if (options_.listener != nullptr)
        ended.emplace_back(outline(*entry), entry->shape->spec.farm().webhook());
    }
  }
  for (const auto& [status, webhook] : ended) options_.listener->ended(status, webhook);
}

void Farm::commit(std::vector<JournalEntry> entries, std::vector<Shown> shown, bool wait, DoneEmpty done) {
  for (const FarmEvent& event : scheduler_.take_events()) {
    // A recovered job that ends the way it had ended before is no news.
    const JobEntry* const entry = event.kind == FarmEvent::Kind::kEnded ? jobs_.find(event.job) : nullptr;
    if (entry != nullptr && entry->durable_end) continue;
    note_event(event, shown);
    // The end that clients are told is the one that is journaled.
    append_to_journal(event, entry != nullptr ? entry->finished_unix_ms : unix_now(), entries);
    if (entry != nullptr) entries.push_back(stats_of(*entry));
  }
  if (entries.empty() && !wait) return done(absl::OkStatus());
  const auto start = std::chrono::steady_clock::now();
  const std::size_t count = entries.size();
  commits_.push(std::move(entries), [this, start, count, shown = std::move(shown),
                                     done = std::move(done)](const absl::Status& status) {
    metrics_.committed(std::chrono::steady_clock::now() - start, count);
    if (!status.ok()) {
      if (!failed_.exchange(true)) {
        spdlog::critical("the journal cannot be written, so nothing more is acknowledged: {}",
                         status.ToString());
        on_failure_(status);
      }
      done(absl::UnavailableError("the coordinator cannot write its journal"));
      return;
    }
    if (!shown.empty()) show(shown);
    dispatcher_.notify_news();
    done(absl::OkStatus());
  });
}

}  // namespace tessera::server
