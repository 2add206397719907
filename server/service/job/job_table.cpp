#include "service/job/job_table.h"

#include <google/protobuf/util/time_util.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "scheduler/identity.h"
#include "service/job/adoption.h"
#include "service/job/journal_events.h"
#include "wire/aov_channels.h"
#include "wire/digest.h"
#include "wire/enum_words.h"
#include "wire/limits.h"
#include "wire/unit_counts.h"

namespace tessera::server {
namespace {

constexpr int kMaxWarningsPerUnit = 8;
constexpr int kMaxWarningsPerJob = 64;
constexpr std::size_t kMaxTimesPerJob = 4096;  // names of materials, above all

/// Which units each result covers, and the blobs that those of phases made.
void note_units(JobEntry& entry, const JobRecord& record) {
  entry.units_by_sequence.clear();
  for (const JobRecord::Result& result : record.results) entry.units_by_sequence.push_back(result.units);
  for (const std::uint64_t sequence : revoked_results(record)) {
    if (sequence > 0 && sequence <= record.results.size())
      entry.units_by_sequence[sequence - 1].first = JobEntry::kRevoked;
  }
  for (std::size_t i = 0; i < record.results.size(); ++i) {
    const std::uint32_t unit = entry.units_by_sequence[i].first;
    if (unit != JobEntry::kRevoked && !entry.shape->plan->is_of_picture(unit))
      entry.phase_blobs.note(unit, record.results[i].digest, i + 1);
  }
}

/// Takes the cost of a result into the pace of its host. Units of phases do work of another kind.
void time_host(JobEntry& entry, const CoveredUnits& units, const std::string& host,
               const v1::UnitStats& stats) {
  if (entry.shape->plan->is_of_picture(units.first)) entry.hosts.time(host, time_of(stats) / units.ranges);
}

}  // namespace

absl::StatusOr<std::shared_ptr<const JobShape>> JobShape::make(v1::JobSpec spec) {
  auto plan = WorkPlan::make(spec);
  if (!plan.ok()) return plan.status();
  std::vector<wire::ChannelDesc> channels = wire::channels_of(spec.view());
  std::string key = result_key(spec);
  const std::size_t spec_bytes = spec.SpaceUsedLong();
  return std::make_shared<const JobShape>(JobShape{std::move(spec),
                                                   std::make_shared<const WorkPlan>(*std::move(plan)),
                                                   std::move(channels), std::move(key), spec_bytes});
}

JobEntry& JobTable::add(JobEntry entry, const std::vector<std::uint64_t>& blob_sizes) {
  blobs_.add(entry.shape->spec, blob_sizes);
  entries_.push_back(std::make_unique<JobEntry>(std::move(entry)));
  JobEntry& added = *entries_.back();
  by_id_[added.id] = &added;
  by_request_[added.request_id] = &added;
  return added;
}

JobEntry* JobTable::find(const std::string& id) {
  const auto found = by_id_.find(id);
  return found == by_id_.end() ? nullptr : found->second;
}

JobEntry* JobTable::find_request(const std::string& request_key) {
  const auto found = by_request_.find(request_key);
  return found == by_request_.end() ? nullptr : found->second;
}

void JobTable::erase(const std::string& id) {
  const JobEntry* const entry = find(id);
  blobs_.remove(entry->shape->spec);
  by_request_.erase(entry->request_id);
  by_id_.erase(id);
  std::erase_if(entries_, [entry](const std::unique_ptr<JobEntry>& other) { return other.get() == entry; });
}

std::string request_key(const std::string& user, const std::string& request_id) {
  return absl::StrCat(user.size(), ":", user, " ", request_id);
}

void add_result(JobEntry& entry, const CoveredUnits& units, const std::string& host,
                const v1::UnitStats& stats) {
  add_stats(entry.stats, stats);
  entry.hosts.count(host, units.ranges);
  time_host(entry, units, host, stats);
  entry.units_by_sequence.push_back(units);
  entry.units += units.ranges;
}

void note_durable(JobEntry& entry, std::uint64_t results) {
  // Units of a job that has long been over are not counted any more.
  for (; entry.durable_results < results; ++entry.durable_results) {
    if (entry.durable_results < entry.units_by_sequence.size()) {
      entry.durable_units += entry.units_by_sequence[entry.durable_results].ranges;
    }
  }
}

JobRequest request_of(const JobEntry& entry) {
  const v1::JobSpec& spec = entry.shape->spec;
  return {.id = entry.id,
          .plan = entry.shape->plan,
          .scene_digest = spec.content().scene(),
          .isa = spec.farm().isa(),
          .priority = spec.farm().priority(),
          .generation = entry.generation,
          .user = spec.farm().user(),
          .required_tags = {spec.farm().required_tags().begin(), spec.farm().required_tags().end()},
          .max_workers = spec.farm().max_workers(),
          .any_class = spec.farm().bits() == v1::BITS_ANY,
          .after = {spec.farm().after().begin(), spec.farm().after().end()}};
}

/// Submissions are refused where they have fields that nobody knows; jobs that were taken must not keep a
/// farm from starting.
absl::StatusOr<v1::JobSpec> read_spec(const std::string& bytes) {
  v1::JobSpec spec;
  if (!spec.ParseFromString(bytes) || !spec.has_content())
    return absl::InvalidArgumentError("its spec cannot be read");
  if (const absl::Status known = wire::check_known(spec); !known.ok())
    spdlog::warn("a job of another version: {}; it is left out", std::string{known.message()});
  spec.DiscardUnknownFields();
  return spec;
}

absl::StatusOr<JobEntry> entry_of(const JobRecord& record) {
  const auto damaged = [&](const std::string& what) {
    return absl::DataLossError(absl::StrCat("journal: job ", record.added.id, ": ", what));
  };
  absl::StatusOr<v1::JobSpec> spec = read_spec(record.added.spec);
  if (!spec.ok()) return damaged(std::string(spec.status().message()));
  auto shape = JobShape::make(*std::move(spec));
  if (!shape.ok()) return damaged(std::string(shape.status().message()));

  JobEntry entry{.id = record.added.id,
                 .request_id = record.added.request_id,
                 .shape = *std::move(shape),
                 .generation = record.added.generation,
                 .submitted_unix_ms = record.added.submitted_unix_ms,
                 .finished_unix_ms = record.ended.finished_unix_ms,
                 .uploaded_bytes = record.added.uploaded_bytes,
                 .past = std::nullopt,
                 .stats = {},
                 .hosts = {},
                 .units_by_sequence = {},
                 .past_revoked = {},
                 .result_bytes = record.result_bytes,
                 .fetched = record.fetched,
                 .durable_results = record.result_count,
                 .durable_end = record.ended.state != 0};
  const std::uint32_t units = entry.shape->plan->unit_count();
  v1::JobCost cost;
  if (!cost.ParseFromString(record.stats.stats)) return damaged("what it cost cannot be read");
  entry.stats = cost.stats();
  entry.hosts = HostShares::restored(cost.hosts());
  const std::vector<std::uint64_t> revoked = revoked_results(record);
  // Rows of jobs that are over are not read; older versions had one unit a result.
  entry.durable_units = !record.results.empty() ? 0
                        : cost.units() > 0      ? cost.units()
                                                : record.result_count - revoked.size();
  // The sums are from before the last revocations; the rows are not.
  if (!record.results.empty()) entry.hosts.clear_counts();
  for (std::size_t i = 0; i < record.results.size(); ++i) {
    const JobRecord::Result& result = record.results[i];
    if (!entry.shape->plan->run(result.units.first, result.units.ranges) || !wire::is_digest(result.digest)) {
      return damaged("a result cannot be read");
    }
    if (!std::binary_search(revoked.begin(), revoked.end(), i + 1)) {
      entry.hosts.count(result.host, result.units.ranges);
      entry.durable_units += result.units.ranges;
    }
    if (i < record.stats.results) continue;
    v1::UnitStats stats;
    if (!stats.ParseFromString(result.stats)) return damaged("a result cannot be read");
    stats = bounded(std::move(stats));
    add_stats(entry.stats, stats);
    time_host(entry, result.units, result.host, stats);
  }
  note_units(entry, record);
  // An incomplete job may be opened again, so the scheduler knows it.
  if (entry.durable_end && record.ended.state != v1::INCOMPLETE) {
    entry.past = JobView{.state = static_cast<v1::JobState>(record.ended.state),
                         .units_total = units,
                         .units_done = static_cast<std::uint32_t>(entry.durable_units),
                         .units_leased = 0,
                         .units_set_aside = 0,
                         .isa = "",
                         .error = record.ended.error,
                         .priority = entry.shape->spec.farm().priority(),
                         .paused = false,
                         .revision = static_cast<std::uint32_t>(revoked.size()),
                         .notes = {},
                         .set_aside = {},
                         .units_adopted = 0,
                         .adopted_from = "",
                         .classes = classes_of(record).all()};
    entry.past->isa =
        entry.past->classes.empty() ? entry.shape->spec.farm().isa() : isas_of(entry.past->classes);
    for (const SchedulerEvent& event : record.events) {
      const auto kind = static_cast<FarmEvent::Kind>(event.kind);
      if (kind == FarmEvent::Kind::kNote) entry.past->notes.push_back(event.text);
      if (kind == FarmEvent::Kind::kUnconfirmed)
        entry.past->units_unconfirmed = static_cast<std::uint32_t>(event.value);
      if (kind != FarmEvent::Kind::kAdopted) continue;
      entry.past->units_adopted = static_cast<std::uint32_t>(event.value);
      entry.past->adopted_from = event.text;
    }
    entry.units_by_sequence = {};
    entry.past_revoked = revoked;
  }
  return entry;
}

void recall(JobEntry& entry, const JobRecord& record) {
  note_units(entry, record);
  entry.past_revoked.clear();
  entry.past.reset();
}

void retire(JobEntry& entry, JobView view) {
  const std::vector<CoveredUnits> units = std::exchange(entry.units_by_sequence, {});
  for (std::size_t i = 0; i < units.size(); ++i) {
    if (units[i].first == JobEntry::kRevoked) entry.past_revoked.push_back(i + 1);
  }
  entry.phase_blobs.keep(entry.shape->plan->phases().roots());
  entry.past = std::move(view);
}

namespace {

/// The first of the noted failures that everyone hears of.
std::size_t first_of_latest(const JobEntry& entry) {
  const std::size_t count = entry.noted_failures.size();
  return count - std::min(count, JobEntry::kLatestFailures);
}

}  // namespace

v1::JobStatus status_of(const JobEntry& entry, const JobView& view) {
  v1::JobStatus status;
  status.set_job_id(entry.id);
  status.set_name(entry.shape->spec.farm().name());
  status.set_state(view.state);
  status.set_units_total(view.units_total);
  // Only what survives a crash is said to be done, so that the number never falls.
  status.set_units_done(std::min(view.units_done, static_cast<std::uint32_t>(entry.durable_units)));
  status.set_units_leased(view.units_leased);
  if (is_open(view.state)) status.set_units_waiting(view.units_pending);
  *status.mutable_stats() = entry.stats;
  status.set_error(view.error);
  status.set_isa(view.isa);
  status.set_submitted_unix_ms(entry.submitted_unix_ms);
  status.set_finished_unix_ms(entry.finished_unix_ms);
  status.set_uploaded_bytes(entry.uploaded_bytes);
  status.set_user(entry.shape->spec.farm().user());
  status.set_priority(view.priority);
  status.set_comment(entry.shape->spec.farm().comment());
  status.set_group(entry.shape->spec.farm().group());
  status.set_frame(entry.shape->spec.farm().frame());
  for (const std::string& id : view.awaited) status.add_after(id);
  status.set_paused(view.paused);
  status.set_units_set_aside(view.units_set_aside);
  if (is_open(view.state) && view.units_open > 0) {
    if (const auto phase = entry.shape->plan->phases().phase_of(view.units_open - 1))
      status.set_phase(entry.shape->spec.cut().phases(static_cast<int>(*phase)).name());
  }
  status.set_revision(view.revision);
  status.set_units_adopted(view.units_adopted);
  status.set_units_unconfirmed(view.units_unconfirmed);
  status.set_audits(view.audits);
  status.set_audits_out(view.audits_out);
  status.set_adopted_from(view.adopted_from);
  for (const std::string& name : view.classes) status.add_arithmetic_classes(name);
  status.set_workers(view.workers);
  status.set_failures(entry.failures);
  for (std::size_t i = first_of_latest(entry); i < entry.noted_failures.size(); ++i) {
    v1::FailedUnit& failed = *status.add_latest_failures() = entry.noted_failures[i].failed;
    failed.mutable_failure()->clear_log();
  }
  for (const std::string& note : view.notes) status.add_notes(note);
  for (const SetAsideView& aside : view.set_aside) {
    v1::SetAsideUnit& unit = *status.add_set_aside();
    *unit.mutable_unit() = entry.shape->plan->unit(aside.unit);
    for (const UnitFailure& failure : aside.failures) {
      v1::UnitFailure& out = *unit.add_failures();
      out.set_host(short_name(failure.host));
      out.set_message(failure.message);
      out.set_lost(failure.lost);
    }
  }
  return status;
}

void add_failure_logs(const JobEntry& entry, const JobView& view, v1::JobStatus& status) {
  for (int i = 0; i < status.latest_failures_size(); ++i) {
    const v1::FailedUnit& noted =
        entry.noted_failures[first_of_latest(entry) + static_cast<std::size_t>(i)].failed;
    *status.mutable_latest_failures(i)->mutable_failure()->mutable_log() = noted.failure().log();
  }
  for (int i = 0; i < status.set_aside_size(); ++i) {
    const SetAsideView& aside = view.set_aside[static_cast<std::size_t>(i)];
    for (std::size_t k = 0; k < aside.failures.size(); ++k) {
      const auto noted =
          std::ranges::find_if(entry.noted_failures, [&](const JobEntry::NotedFailure& failure) {
            return failure.failed.unit_index() == aside.unit && failure.grant == aside.failures[k].grant &&
                   failure.grant != 0;
          });
      if (noted == entry.noted_failures.end()) continue;
      v1::SetAsideUnit& unit = *status.mutable_set_aside(i);
      *unit.mutable_failures(static_cast<int>(k))->mutable_log() = noted->failed.failure().log();
    }
  }
}

JobStats stats_of(const JobEntry& entry) {
  v1::JobCost cost;
  *cost.mutable_stats() = entry.stats;
  entry.hosts.save(*cost.mutable_hosts());
  for (const CoveredUnits& units : entry.units_by_sequence) {
    if (units.first != JobEntry::kRevoked) cost.set_units(cost.units() + units.ranges);
  }
  return {.id = entry.id, .results = entry.units_by_sequence.size(), .stats = cost.SerializeAsString()};
}

namespace {

using Lines = google::protobuf::RepeatedPtrField<std::string>;
using TimeMap = google::protobuf::Map<std::string, google::protobuf::uint64>;

void add_times(TimeMap& total, const TimeMap& unit) {
  for (const auto& [name, nanoseconds] : unit) {
    if (total.size() < kMaxTimesPerJob || total.contains(name)) total[name] += nanoseconds;
  }
}

/// Adds durations that may be anything: a damaged journal has some, too. At most what a Duration may hold,
/// 10,000 years.
google::protobuf::Duration sum_of(const google::protobuf::Duration& a, const google::protobuf::Duration& b) {
  using google::protobuf::util::TimeUtil;
  constexpr std::int32_t kSecond = 1'000'000'000;  // nanoseconds
  const auto seconds_of = [](const google::protobuf::Duration& time) {
    return std::clamp<std::int64_t>(time.seconds(), 0, TimeUtil::kDurationMaxSeconds);
  };
  const std::int32_t nanos = std::clamp(a.nanos(), 0, kSecond - 1) + std::clamp(b.nanos(), 0, kSecond - 1);
  google::protobuf::Duration sum;
  sum.set_seconds(
      std::min<std::int64_t>(seconds_of(a) + seconds_of(b) + nanos / kSecond, TimeUtil::kDurationMaxSeconds));
  sum.set_nanos(nanos % kSecond);
  return sum;
}

/// Names from a broken worker must not fill the memory, nor its clock spoil the sum.
void bound_times(TimeMap& times, std::uint64_t most) {
  bool sound = times.size() <= kMaxTimesPerJob;
  for (const auto& [name, nanoseconds] : times)
    sound = sound && name.size() <= wire::kMaxTextBytes && nanoseconds <= most;
  if (!sound) times.clear();
}

/// Adds those that are not known yet, up to the job's bound.
void add_new_lines(Lines& known, const Lines& lines) {
  for (const std::string& line : lines) {
    if (known.size() >= kMaxWarningsPerJob) break;
    if (std::find(known.begin(), known.end(), line) == known.end()) *known.Add() = line;
  }
}

}  // namespace

std::chrono::nanoseconds time_of(const v1::UnitStats& unit) {
  return std::chrono::nanoseconds(google::protobuf::util::TimeUtil::DurationToNanoseconds(unit.wall_time()));
}

void add_stats(v1::UnitStats& total, const v1::UnitStats& unit) {
  wire::RenderCounts counts = wire::counts_of(total);
  wire::set_counts(counts += wire::counts_of(unit), total);
  *total.mutable_cpu_time() = sum_of(total.cpu_time(), unit.cpu_time());
  *total.mutable_wall_time() = sum_of(total.wall_time(), unit.wall_time());
  total.set_blob_bytes_fetched(total.blob_bytes_fetched() + unit.blob_bytes_fetched());
  add_times(*total.mutable_stage_ns(), unit.stage_ns());
  add_times(*total.mutable_shading_part_ns(), unit.shading_part_ns());
  add_times(*total.mutable_material_ns(), unit.material_ns());
  add_new_lines(*total.mutable_warnings(), unit.warnings());
  add_new_lines(*total.mutable_notes(), unit.notes());
}

v1::UnitStats bounded_by(v1::UnitStats stats, std::chrono::milliseconds lasted, std::uint32_t threads) {
  using google::protobuf::util::TimeUtil;
  // Both ends of `lasted` are whole milliseconds.
  const std::int64_t wall_ms = std::max<std::int64_t>(0, lasted.count()) + 1;
  const auto bound = [](google::protobuf::Duration& time, std::int64_t most_ms) {
    if (TimeUtil::DurationToMilliseconds(time) >= most_ms) time = TimeUtil::MillisecondsToDuration(most_ms);
  };
  const std::int64_t cpu_ms = wall_ms * threads;
  if (stats.has_wall_time()) bound(*stats.mutable_wall_time(), wall_ms);
  if (stats.has_cpu_time()) bound(*stats.mutable_cpu_time(), cpu_ms);
  for (TimeMap* times :
       {stats.mutable_stage_ns(), stats.mutable_shading_part_ns(), stats.mutable_material_ns()}) {
    bound_times(*times, static_cast<std::uint64_t>(cpu_ms) * 1'000'000);
  }
  return stats;
}

v1::UnitStats bounded(v1::UnitStats stats) {
  for (Lines* lines : {stats.mutable_warnings(), stats.mutable_notes()}) {
    if (lines->size() > kMaxWarningsPerUnit)
      lines->DeleteSubrange(kMaxWarningsPerUnit, lines->size() - kMaxWarningsPerUnit);
    for (std::string& line : *lines) {
      if (line.size() > wire::kMaxTextBytes) line.resize(wire::kMaxTextBytes);
    }
  }
  // Durations from a broken clock must not spoil the sum.
  constexpr std::int64_t kLongest = 30 * 24 * 3600;  // seconds
  for (google::protobuf::Duration* time : {stats.mutable_cpu_time(), stats.mutable_wall_time()}) {
    if (time->seconds() < 0 || time->seconds() > kLongest || time->nanos() < 0 ||
        time->nanos() > 999'999'999) {
      time->Clear();
    }
  }
  for (TimeMap* times :
       {stats.mutable_stage_ns(), stats.mutable_shading_part_ns(), stats.mutable_material_ns()}) {
    bound_times(*times, static_cast<std::uint64_t>(kLongest) * 1'000'000'000);
  }
  return stats;
}

}  // namespace tessera::server
