#include "service/farm/farm_core.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "scheduler/identity.h"
#include "service/farm/lease_seal.h"
#include "service/job/end_listener.h"
#include "service/job/journal_events.h"

namespace tessera::server {
namespace {

SchedulerOptions scheduler_options(const FarmOptions& options, std::uint64_t epoch) {
  return {.heartbeat_interval = options.heartbeat_interval,
          .lease_timeout = options.lease_timeout,
          .longest_run = options.longest_run,
          .order = options.order,
          .epoch = epoch,
          .unconfirmed_share = options.unconfirmed_share,
          .audit_key = options.seal->derive_key("audits"),
          .settle = options.settle,
          .classes = options.classes,
          .class_patience = options.class_patience};
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

FarmCore::FarmCore(Journal& journal, BlobStore& blobs, const FarmOptions& options,
                   std::function<void(absl::Status)> on_failure)
    : journal_(journal),
      blobs_(blobs),
      options_(options),
      clock_(*options.clock),
      on_failure_(std::move(on_failure)),
      scheduler_(scheduler_options(options, journal.epoch())),
      dispatcher_(clock_,
                  [this] {
                    const TimedCall timed(*this, news::Call::kTick);
                    const std::lock_guard lock(mutex_);
                    if (tick_) tick_();
                  }),
      commits_(std::in_place, journal, clock_) {}

// ---------------------------------------------------------------- the farm's life

absl::Status FarmCore::recover() {
  absl::Status status = restore_farm(scheduler_, journal_);
  status.Update(journal_.recover([this](JobRecord record) { return recover(std::move(record)); }));
  if (status.ok()) commit();
  return status;
}

absl::Status FarmCore::recover(JobRecord record) {
  absl::StatusOr<JobEntry> made = entry_of(record);
  if (!made.ok()) return made.status();
  std::vector<std::uint64_t> sizes;
  for (const v1::BlobRef& blob : made->shape->spec.farm().blobs()) {
    const std::optional<std::uint64_t> known = jobs_.blobs().size_of(blob.digest());
    sizes.push_back(known ? *known : blobs_.query(blob.digest()).stored_bytes);
  }
  JobEntry& entry = jobs_.add(*std::move(made), sizes);
  absl::Status status = absl::OkStatus();
  if (!entry.past) status = restore_job(scheduler_, request_of(entry), record);
  if (record.whole_results < record.result_count)
    tell(news::ResultsLost{entry, record.result_count - record.whole_results});
  if (entry.past) return absl::OkStatus();

  for (std::uint64_t sequence = record.whole_results + 1; status.ok() && sequence <= record.result_count;
       ++sequence) {
    status.Update(do_again(entry, sequence, absl::DataLossError("its result is not on the disk any more")));
  }
  tell(news::JobRecovered{entry, scheduler_.job(entry.id)->units_done});
  return status;
}

void FarmCore::start(std::function<void()> tick) {
  tick_ = std::move(tick);
  starting_.unlock();
}

bool FarmCore::stop() {
  const bool is_first = !stopping_.exchange(true);
  if (starting_.owns_lock()) starting_.unlock();  // it was not recovered
  dispatcher_.stop();
  return is_first;
}

absl::Status FarmCore::check_serving() const {
  return stopping_ ? absl::UnavailableError("the coordinator is shutting down") : absl::OkStatus();
}

// ---------------------------------------------------------------- the state

Time FarmCore::now() const { return std::chrono::duration_cast<Time>(clock_.now().time_since_epoch()); }

void FarmCore::tell(const FarmNews& news) const {
  for (FarmObserver* const observer : options_.observers) observer->note(news);
}

absl::StatusOr<JobEntry*> FarmCore::find_job(const std::string& id) {
  JobEntry* const entry = jobs_.find(id);
  if (entry == nullptr) return absl::NotFoundError(absl::StrCat("there is no job ", id));
  return entry;
}

JobView FarmCore::view_of(const JobEntry& entry) const {
  return entry.past ? *entry.past : *scheduler_.job(entry.id);
}

v1::JobStatus FarmCore::outline(const JobEntry& entry) const {
  v1::JobStatus status = status_of(entry, view_of(entry));
  const std::int64_t end = entry.finished_unix_ms != 0 ? entry.finished_unix_ms : unix_now();
  status.set_elapsed_ms(std::max<std::int64_t>(end - entry.submitted_unix_ms, 0));
  if (is_open(status.state()) && !status.paused()) {
    const std::uint32_t left = status.units_total() - status.units_done() - status.units_set_aside();
    if (const auto time = entry.rate.time_for(left, now())) status.set_left_ms(time->count());
  }
  return status;
}

absl::Status FarmCore::do_again(JobEntry& entry, std::uint64_t sequence, const absl::Status& damage) {
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
  commit();
  dispatcher_.notify_work();
  return absl::IsFailedPrecondition(status) ? damage : status;
}

// ---------------------------------------------------------------- the journal

void FarmCore::commit(Change change, DoneEmpty done) {
  add_events(change);
  push(std::move(change), std::move(done));
}

void FarmCore::commit() {
  Change change;
  add_events(change);
  if (!change.entries.empty()) push(std::move(change), [](const absl::Status&) {});
}

void FarmCore::add_events(Change& change) {
  for (const FarmEvent& event : scheduler_.take_events()) {
    // A recovered job that ends the way it had ended before is no news.
    const JobEntry* const entry = event.kind == FarmEvent::Kind::kEnded ? jobs_.find(event.job) : nullptr;
    if (entry != nullptr && entry->durable_end) continue;
    note_event(event, change.shown);
    // The end that clients are told is the one that is journaled.
    append_to_journal(event, entry != nullptr ? entry->finished_unix_ms : unix_now(), change.entries);
    if (entry != nullptr) change.entries.push_back(stats_of(*entry));
  }
}

void FarmCore::push(Change change, DoneEmpty done) {
  const auto start = std::chrono::steady_clock::now();
  const std::size_t count = change.entries.size();
  commits_->push(std::move(change.entries), [this, start, count, shown = std::move(change.shown),
                                             done = std::move(done)](const absl::Status& status) {
    tell(news::Committed{std::chrono::steady_clock::now() - start, count});
    if (!status.ok()) {
      fail(status);
      done(absl::UnavailableError("the coordinator cannot write its journal"));
      return;
    }
    if (!shown.empty()) show(shown);
    dispatcher_.notify_news();
    done(absl::OkStatus());
  });
}

void FarmCore::fail(const absl::Status& why) {
  if (failed_.exchange(true)) return;
  tell(news::JournalFailed{why});
  on_failure_(why);
}

void FarmCore::show(const std::vector<Shown>& shown) {
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

void FarmCore::note_event(const FarmEvent& event, std::vector<Shown>& shown) {
  if (event.kind == FarmEvent::Kind::kDistrusted) {
    tell(news::HostDistrusted{event.host, event.text});
    for (const auto& entry : jobs_.all()) note_distrusted(*entry, event.host);
  }
  JobEntry* const entry = event.job.empty() ? nullptr : jobs_.find(event.job);
  if (entry == nullptr) return;
  switch (event.kind) {
    case FarmEvent::Kind::kEnded:
      entry->finished_unix_ms = unix_now();
      shown.push_back({.job = event.job, .results = 0, .end = true, .times_reopened = entry->times_reopened});
      tell(news::JobEnded{*entry, static_cast<v1::JobState>(event.value), event.text});
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
      tell(news::JobNoted{*entry, event.text});
      return;
    default:
      return;
  }
}

void FarmCore::note_distrusted(const JobEntry& entry, const std::string& subject) {
  std::uint32_t units = 0;
  for (const std::string& host : entry.hosts.hosts())
    units += covers(subject, host) ? entry.hosts.units_of(host) : 0;
  if (units == 0) return;
  // All results of an open job are revoked, and rendered again.
  if (!entry.past && is_open(scheduler_.job(entry.id)->state)) return;
  tell(news::ResultsDoubted{entry, subject, units});
}

}  // namespace tessera::server
