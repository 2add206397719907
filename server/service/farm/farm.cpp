// Opening, journaling and submission. What clients do with jobs is in farm_jobs.cpp, what workers call in
// farm_workers.cpp.
#include "service/farm/farm.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "scheduler/identity.h"
#include "service/identifier.h"
#include "service/job/journal_events.h"
#include "telemetry/log.h"
#include "wire/arithmetic_class.h"
#include "wire/limits.h"
#include "wire/version.h"

namespace tessera::server {
namespace {

// Specs stay in memory for as long as their jobs are kept.
constexpr std::uint64_t kMaxSpecBytes = std::uint64_t{2} << 30,
                        kMaxSpecBytesOfUser = std::uint64_t{512} << 20;

telemetry::LogFields fields_of(const JobEntry& entry) {
  return {.job = entry.id, .user = entry.shape->spec.farm().user()};
}

/// For who watches the job.
void note_failure(JobEntry& entry, const FarmEvent& event) {
  ++entry.failures;
  v1::FailedUnit& failed = entry.latest_failures.emplace_back();
  const bool run_lost = event.kind == FarmEvent::Kind::kRunLost,
             run_failed = event.kind == FarmEvent::Kind::kRunFailed;
  failed.set_unit_index(event.unit);
  if (run_lost || run_failed) failed.set_ranges(static_cast<std::uint32_t>(event.value));
  failed.mutable_failure()->set_host(short_name(event.host));
  failed.mutable_failure()->set_message(event.text);
  failed.mutable_failure()->set_lost(run_lost || event.kind == FarmEvent::Kind::kUnitLost);
  if (entry.latest_failures.size() > JobEntry::kLatestFailures) entry.latest_failures.pop_front();
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
                  .audit_key = seal_->derive_key("audits"),
                  .settle = options.settle}),
      lived_(options.lived_time),
      next_collection_(now() + kLongestBetweenCollections),
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
  live_on();
  if (saver_.joinable()) saver_.join();
  if (absl::Status status = LivedTime::save(lived_.file(), lived_.to_text()); !status.ok()) {
    spdlog::error("{}", std::string(status.message()));
  }
}

absl::Status Farm::recover(JobRecord record) {
  absl::StatusOr<JobEntry> made = entry_of(record);
  if (!made.ok()) return made.status();
  JobEntry& entry = jobs_.add(*std::move(made));
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
      shown.push_back({.job = event.job, .bound = true});
      return;
    case FarmEvent::Kind::kReopened:
      entry->durable_end = false;
      ++entry->times_reopened;
      entry->finished_unix_ms = 0;
      entry->fetched = false;
      return;
    case FarmEvent::Kind::kUnitFailed:
    case FarmEvent::Kind::kUnitLost:
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
    if (!shown.empty()) {
      const std::lock_guard lock(mutex_);
      for (const Shown& news : shown) {
        JobEntry* const entry = jobs_.find(news.job);
        if (entry == nullptr) continue;
        note_durable(*entry, news.results);
        entry->durable_end |= news.end && news.times_reopened == entry->times_reopened;
        entry->bounds_under_way -= news.bound;
      }
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
  for (const v1::BlobRef& blob : spec.farm().blobs()) look_for(blob);
  if (missing == 0) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(missing, " blobs are missing; upload them first. One is ",
                                                    first->digest(), " (", first->path(), ")"));
}

absl::Status Farm::check_capacity(const JobShape& shape) const {
  std::uint64_t units = shape.plan->unit_count();
  std::uint64_t bytes = shape.spec_bytes, bytes_of_user = bytes;
  for (const auto& entry : jobs_.all()) {
    units += entry->past ? 0 : entry->shape->plan->unit_count();
    bytes += entry->shape->spec_bytes;
    if (entry->shape->spec.farm().user() == shape.spec.farm().user())
      bytes_of_user += entry->shape->spec_bytes;
  }
  if (bytes > kMaxSpecBytes || bytes_of_user > kMaxSpecBytesOfUser) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "with this job's, the specs of the jobs that are kept would have ", bytes, " bytes, and those of '",
        shape.spec.farm().user(), "' ", bytes_of_user, "; at most ", kMaxSpecBytes, " and ",
        kMaxSpecBytesOfUser, " are taken; try again when old jobs are deleted"));
  }
  if (units <= options_.max_open_units) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat("with this job's, the jobs that are not over would have ", units, " units, more than the ",
                   options_.max_open_units, " that the coordinator keeps; try again when some are done"));
}

std::uint64_t Farm::claim_uploads(const v1::JobSpec& spec) {
  std::uint64_t bytes = 0;
  const auto claim = [&](const v1::BlobRef& blob) {
    if (const auto found = unclaimed_uploads_.find(blob.digest()); found != unclaimed_uploads_.end()) {
      bytes += found->second;
      unclaimed_uploads_.erase(found);
    }
  };
  for (const v1::BlobRef& blob : spec.farm().blobs()) claim(blob);
  return bytes;
}

void Farm::note_upload(const std::string& digest, std::uint64_t bytes) {
  metrics_.uploaded(bytes);
  const std::lock_guard lock(mutex_);
  unclaimed_uploads_[digest] += bytes;
}

absl::StatusOr<const JobEntry*> Farm::best_donor(const v1::SubmitJobRequest& request,
                                                 const v1::JobSpec& spec) {
  // Whether it has results of the kernels asked for.
  const auto has_isa = [&](const JobEntry& entry) {
    const std::vector<std::string> classes = view_of(entry).classes;
    return spec.farm().isa().empty() ||
           std::any_of(classes.begin(), classes.end(),
                       [&](const std::string& name) { return wire::isa_of(name) == spec.farm().isa(); });
  };
  if (const std::string& id = request.continued(); !id.empty()) {
    const absl::StatusOr<JobEntry*> named = find_job(id);
    if (!named.ok()) return named.status();
    std::string difference = difference_in_content((*named)->shape->spec, spec);
    if (const JobView view = view_of(**named);
        difference.empty() && !view.classes.empty() && !has_isa(**named)) {
      difference = absl::StrCat("modified: isa: \"", view.isa, "\" -> \"", spec.farm().isa(), "\"");
    }
    if (difference.empty()) return *named;
    return absl::FailedPreconditionError(
        absl::StrCat("job ", id, " cannot be continued by this one; ", difference));
  }
  const JobEntry* best = nullptr;
  const std::string key = result_key(spec);
  for (const auto& entry : jobs_.all()) {
    const v1::JobSpec& other = entry->shape->spec;
    if (!options_.share_results && other.farm().user() != spec.farm().user()) continue;
    if (entry->durable_results == 0 || entry->shape->key != key ||
        (best != nullptr && best->durable_units >= entry->durable_units)) {
      continue;
    }
    if (has_isa(*entry)) best = entry.get();
  }
  return best;
}

absl::StatusOr<std::optional<Donor>> Farm::find_donor(const v1::SubmitJobRequest& request,
                                                      const JobShape& shape) {
  if (request.fresh()) return std::nullopt;
  Donor donor;
  std::string id;
  {
    const std::lock_guard lock(mutex_);
    if (jobs_.find_request(request_key(shape.spec.farm().user(), request.request_id())) != nullptr)
      return std::nullopt;
    const absl::StatusOr<const JobEntry*> best = best_donor(request, shape.spec);
    if (!best.ok()) return best.status();
    if (*best == nullptr) return std::nullopt;
    id = (*best)->id;
    donor.plan = (*best)->shape->plan;
    donor.named = !request.continued().empty();
  }
  // Thousands of rows, maybe: not under the lock. What was deleted meanwhile is no donor.
  absl::StatusOr<JobRecord> record = journal_.read_job(id);
  if (absl::IsNotFound(record.status())) return std::nullopt;
  if (!record.ok()) return record.status();
  donor.record = *std::move(record);
  return donor;
}

absl::StatusOr<std::vector<JournalEntry>> Farm::add_job(JobEntry& entry, const std::optional<Donor>& donor) {
  const v1::JobSpec& spec = entry.shape->spec;
  std::vector<JournalEntry> entries;
  entries.push_back(JobAdded{.id = entry.id,
                             .request_id = entry.request_id,
                             .spec = spec.SerializeAsString(),
                             .generation = entry.generation,
                             .submitted_unix_ms = entry.submitted_unix_ms,
                             .uploaded_bytes = entry.uploaded_bytes});
  if (absl::Status status = scheduler_.add_job(request_of(entry)); !status.ok()) return status;
  telemetry::log(spdlog::level::info, fields_of(entry), "job {} \"{}\": {} x {} pixels, {} samples, {} units",
                 entry.id, spec.farm().name(), spec.view().width(), spec.view().height(),
                 spec.samples().spp(), entry.shape->plan->unit_count());
  // The donor may have been deleted since it was read, and with it what would be copied.
  if (!donor || jobs_.find(donor->record.added.id) == nullptr) return entries;
  const auto has_blob = [this](const std::string& digest) { return blobs_.query(digest).complete; };
  if (absl::Status status = adopt_results(scheduler_, request_of(entry), *donor, has_blob, entries);
      !status.ok()) {
    return status;
  }
  for (const JournalEntry& journaled : entries) {
    const auto* const done = std::get_if<UnitDone>(&journaled);
    if (done == nullptr) continue;
    v1::UnitStats stats;
    static_cast<void>(stats.ParseFromString(done->stats));
    add_result(entry, done->units, done->host, stats);
    if (!entry.shape->plan->is_of_picture(done->units.first))
      entry.phase_blobs.note(done->units.first, done->digest, done->sequence);
    entry.result_bytes += donor->record.results[done->from_sequence - 1].bytes;
  }
  if (entry.units > 0) {
    telemetry::log(spdlog::level::info, fields_of(entry), "job {}: {} units are taken over from job {}",
                   entry.id, entry.units, donor->record.added.id);
  }
  return entries;
}

void Farm::submit(const v1::SubmitJobRequest& request, Done<std::string> done) {
  if (absl::Status status = check_serving(); !status.ok()) return done(std::move(status));
  if (request.request_id().empty() || request.request_id().size() > wire::kMaxTextBytes) {
    return done(absl::InvalidArgumentError("request_id is empty or too long"));
  }
  v1::JobSpec spec = request.spec();
  spec.mutable_content()->set_build(wire::build_version());
  if (spec.farm().bits() == v1::BITS_UNSPECIFIED) spec.mutable_farm()->set_bits(options_.bits);
  if (spec.farm().isa().empty()) spec.mutable_farm()->set_isa(options_.isa);
  auto shape = JobShape::make(std::move(spec));
  if (!shape.ok()) return done(shape.status());
  if (absl::Status status = check_blobs(request.spec()); !status.ok()) return done(std::move(status));
  const absl::StatusOr<std::optional<Donor>> donor = find_donor(request, **shape);
  if (!donor.ok()) return done(donor.status());

  // The journal keeps the spec, and results follow.
  const absl::Status room = blobs_.check_room(request.ByteSizeLong());
  const std::string key = request_key((*shape)->spec.farm().user(), request.request_id());

  std::unique_lock lock(mutex_);
  if (const JobEntry* const known = jobs_.find_request(key)) {
    // Sent a second time: the answer is the same, once the first is durable.
    return commit({}, {}, /*wait=*/true,
                  [id = known->id, done = std::move(done)](const absl::Status& status) {
                    status.ok() ? done(id) : done(status);
                  });
  }
  if (!room.ok()) return done(room);
  if (absl::Status status = check_capacity(**shape); !status.ok()) return done(std::move(status));
  std::string id = random_identifier(8);
  while (jobs_.find(id) != nullptr) id = random_identifier(8);
  JobEntry& entry = jobs_.add({.id = id,
                               .request_id = key,
                               .shape = *shape,
                               .submitted_unix_ms = unix_now(),
                               .uploaded_bytes = claim_uploads((*shape)->spec),
                               .past = std::nullopt,
                               .stats = {},
                               .hosts = {},
                               .units_by_sequence = {},
                               .past_revoked = {}});
  absl::StatusOr<std::vector<JournalEntry>> entries = add_job(entry, *donor);
  if (!entries.ok()) return done(entries.status());
  // Workers may begin at once: their results are journaled after the job.
  commit(*std::move(entries), {{.job = id, .results = entry.units_by_sequence.size(), .end = false}},
         /*wait=*/true, [id, done = std::move(done)](const absl::Status& committed) {
           committed.ok() ? done(id) : done(committed);
         });
  lock.unlock();
  dispatcher_.notify_work();
}

}  // namespace tessera::server
