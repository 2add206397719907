#include "store/log/log_recovery.h"

#include <sqlite3.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "store/data_dir.h"
#include "store/log/checksum.h"

namespace tessera::server {
namespace {

constexpr char kLogSuffix[] = ".log";

/// Whether the entry may come next in the log of `job`, of which the tables have the row, if so, and so many
/// results.
bool follows(const LoggedEntry& logged, const std::string& job, bool has_row, std::uint64_t results) {
  if (job.empty()) return log_of(logged.entry).empty();
  if (log_of(logged.entry) != job || std::holds_alternative<JobAdded>(logged.entry) == has_row) return false;
  const auto* const unit = std::get_if<UnitDone>(&logged.entry);
  return unit == nullptr || unit->sequence == results + 1;
}

}  // namespace

LogRecovery::LogRecovery(Disk& disk, std::filesystem::path data_dir, SQLite::Database& database,
                         JournalTables& tables, bool new_tables,
                         const std::optional<ManifestCounts>& expected)
    : disk_(disk),
      data_dir_(std::move(data_dir)),
      database_(database),
      tables_(tables),
      rows_(database),
      new_tables_(new_tables),
      expected_(expected) {}

std::filesystem::path LogRecovery::path_of(const std::string& job) const { return log_path(data_dir_, job); }

absl::StatusOr<LogRecovery::Report> LogRecovery::complete_tables() {
  report_.counts.epoch = rows_.meta("epoch");
  const std::uint64_t known = report_.counts.commit = rows_.meta("commit");
  if (!expected_ && rows_.log_bytes("").has_value())
    report_.healed.push_back("the manifest was missing or damaged");
  if (absl::Status status = find_tails(); !status.ok()) return status;
  drop_unfinished();
  for (const std::string& job : pruned_) tables_.write(JobPruned{job}, 0);
  std::sort(tails_.begin(), tails_.end(), [](const Tail& a, const Tail& b) {
    return std::tie(a.submitted_unix_ms, a.first.commit, a.first.index, a.job) <
           std::tie(b.submitted_unix_ms, b.first.commit, b.first.index, b.job);
  });
  for (Tail& tail : tails_) {
    if (absl::Status status = take_in(tail); !status.ok()) return status;
  }
  tables_.write_commit(report_.counts.commit);
  // One commit more may be of a coordinator that ended before it had said so to anybody.
  const bool told = report_.counts.commit > known + 1 || (expected_ && expected_->commit > known);
  if (told && report_.counts.commit > known) {
    report_.healed.push_back(absl::StrCat("its tables ended with commit ", known, ": commits up to ",
                                          report_.counts.commit,
                                          " are taken from the logs beside the results"));
  }
  for (const std::string& job : incomplete_) tables_.forget_log(job);
  report_.changed = !tails_.empty() || !incomplete_.empty() || !pruned_.empty() || new_tables_;
  if (absl::Status status = compare(rows_.ids()); !status.ok()) return status;
  return report_;
}

absl::Status LogRecovery::find_tails() {
  absl::StatusOr<std::vector<std::string>> names = disk_.list(data_dir_ / "results");
  if (!names.ok()) return names.status();
  names_ = *std::move(names);
  const auto note_deleted = [&](const LogFrame& frame) {
    if (const auto* const pruned = std::get_if<JobPruned>(&frame.logged.entry)) pruned_.insert(pruned->id);
    return true;
  };
  if (const auto read = read_log(disk_, path_of(""), 0, note_deleted); !read.ok()) return read.status();

  const std::vector<std::string> rows = rows_.ids();
  const absl::flat_hash_set<std::string> ids(rows.begin(), rows.end());
  absl::Status status = look_at("", /*has_row=*/true);
  for (const std::string& id : rows) {
    if (!pruned_.contains(id)) status.Update(look_at(id, /*has_row=*/true));
  }
  for (const std::string& name : names_) {
    const std::string id(absl::StripSuffix(name, kLogSuffix));
    if (id != name && !ids.contains(id) && !pruned_.contains(id))
      status.Update(look_at(id, /*has_row=*/false));
  }
  return status;
}

absl::Status LogRecovery::look_at(const std::string& job, bool has_row) {
  const std::optional<std::uint64_t> known = rows_.log_bytes(job);
  const auto file = disk_.open(path_of(job), /*create=*/false);
  if (!file.ok() && !absl::IsNotFound(file.status())) return file.status();
  const absl::StatusOr<std::uint64_t> size = file.ok() ? (*file)->size() : 0;
  if (!size.ok()) return size.status();
  const bool never_written = has_row && !known && !(new_tables_ && file.ok());
  if (never_written || *size < known.value_or(0)) {
    if (!never_written) {
      report_.healed.push_back(absl::StrCat(path_of(job).string(), " was ", file.ok() ? "cut" : "missing",
                                            ", and is written anew from the journal"));
    }
    incomplete_.push_back(job);
    return absl::OkStatus();
  }
  if (*size == known.value_or(0) && has_row) return absl::OkStatus();
  Tail tail;
  tail.job = job;
  tail.from = known.value_or(0);
  tail.size = *size;
  if (absl::Status status = read_tail(tail); !status.ok()) return status;
  tails_.push_back(std::move(tail));
  return absl::OkStatus();
}

absl::Status LogRecovery::read_tail(Tail& tail) {
  const absl::StatusOr<std::uint64_t> end =
      read_log(disk_, path_of(tail.job), tail.from, [&](LogFrame frame) {
        report_.counts.epoch = std::max<std::uint64_t>(report_.counts.epoch, frame.stamp.epoch);
        if (frame.begin == tail.from) tail.first = frame.stamp;
        if (const auto* const added = std::get_if<JobAdded>(&frame.logged.entry)) {
          tail.submitted_unix_ms = added->submitted_unix_ms;
        }
        if (frame.stamp.commit != tail.last.commit) {
          tail.previous_commit = std::exchange(tail.last, frame.stamp).commit;
          tail.last_frames_begin = frame.begin;
          tail.last_entries.clear();
        }
        tail.last_entries.push_back(std::move(frame.logged));
        return true;
      });
  if (end.ok()) tail.end = *end;
  return end.status();
}

bool LogRecovery::has_payload(const LoggedEntry& logged) {
  const PayloadPlace& place = logged.payload;
  if (place.bytes == 0 || place.bytes > place.end) return place.bytes == 0;
  const auto file = disk_.open(result_path(data_dir_, log_of(logged.entry)), /*create=*/false);
  if (!file.ok()) return false;
  const absl::StatusOr<std::uint64_t> size = (*file)->size();
  if (!size.ok() || *size < place.end) return false;
  std::string payload(place.bytes, '\0');
  return (*file)->read_at(place.end - place.bytes, payload.data(), payload.size()).ok() &&
         checksum(payload, 0) == place.sum;
}

/// Whether all entries of the commit, which is the last of any log, are there.
bool LogRecovery::is_complete(std::uint64_t commit) {
  std::uint64_t seen = 0, entries = 0;
  bool written_anew = false, has_payloads = true;
  for (const Tail& tail : tails_) {
    if (tail.last.commit != commit) continue;
    written_anew |= tail.last.entries == 0;
    entries = tail.last.entries;
    seen += tail.last_entries.size();
    for (const LoggedEntry& logged : tail.last_entries) has_payloads = has_payloads && has_payload(logged);
  }
  return written_anew || (has_payloads && seen == entries);
}

/// The last commit may have been under way when the coordinator ended: all of it counts, or nothing.
void LogRecovery::drop_unfinished() {
  std::uint64_t last = 0, before = 0;
  for (const Tail& tail : tails_) last = std::max(last, tail.last.commit);
  const bool acknowledged = expected_ && expected_->commit >= last;
  if (last > report_.counts.commit && !acknowledged && !is_complete(last)) {
    for (Tail& tail : tails_) {
      if (tail.last.commit == last) {
        tail.end = tail.last_frames_begin;
        tail.last.commit = tail.previous_commit;
      }
      before = std::max(before, tail.last.commit);
    }
    last = before;
  }
  report_.counts.commit = std::max(report_.counts.commit, last);
}

absl::Status LogRecovery::take_in(Tail& tail) {
  std::uint64_t results = rows_.result_count(tail.job);
  bool has_row = tail.from > 0;
  database_.exec("SAVEPOINT log");
  absl::StatusOr<std::uint64_t> end;
  try {
    end = read_log(disk_, path_of(tail.job), tail.from, [&](const LogFrame& frame) {
      if (frame.begin >= tail.end || !follows(frame.logged, tail.job, has_row, results)) return false;
      has_row = true;
      if (std::holds_alternative<UnitDone>(frame.logged.entry)) ++results;
      if (!std::holds_alternative<JobPruned>(frame.logged.entry)) {
        tables_.write(frame.logged.entry, frame.logged.payload.end);
      }
      return true;
    });
    if (!end.ok()) return end.status();
  } catch (const SQLite::Exception& error) {
    if (error.getErrorCode() != SQLITE_CONSTRAINT) throw;
    database_.exec("ROLLBACK TO log");
    end = tail.from;
  }
  database_.exec("RELEASE log");
  const bool cut_where_it_ended = *end == tail.end;
  tail.end = *end;
  if (has_row || tail.job.empty()) tables_.write_log(tail.job, *end);
  if (*end == tail.size) return absl::OkStatus();
  if (cut_where_it_ended && may_be_torn()) return absl::OkStatus();
  damaged_.push_back(tail.job);
  if (*end > 0) incomplete_.push_back(tail.job);
  return absl::OkStatus();
}

absl::Status LogRecovery::compare(const std::vector<std::string>& ids) {
  ManifestCounts& counts = report_.counts;
  counts.jobs = ids.size();
  for (const std::string& id : ids) counts.results += rows_.result_count(id);
  const bool proven = expected_ && counts.commit == expected_->commit && counts.jobs == expected_->jobs &&
                      counts.results == expected_->results;
  std::vector<std::string>& doubtful = proven ? report_.healed : report_.lost;
  for (const std::string& job : damaged_) {
    const auto tail = std::find_if(tails_.begin(), tails_.end(), [&](const Tail& t) { return t.job == job; });
    doubtful.push_back(absl::StrCat(path_of(job).string(), " is damaged at byte ", tail->end,
                                    ": what was journaled behind that is not known"));
  }
  if (expected_ && (counts.commit < expected_->commit || (counts.commit == expected_->commit && !proven))) {
    report_.lost.push_back(absl::StrCat("it holds ", counts.commit, " commits, ", counts.jobs, " jobs and ",
                                        counts.results, " results; the manifest says ", expected_->commit,
                                        ", ", expected_->jobs, " and ", expected_->results));
  }
  const absl::flat_hash_set<std::string> known(ids.begin(), ids.end());
  for (const std::string& name : names_) {
    if (expected_ && may_be_torn()) break;  // payloads may be of a submission that never was committed
    const bool unfinished = std::any_of(tails_.begin(), tails_.end(), [&](const Tail& tail) {
      return tail.job == name && is_unfinished(tail);
    });
    if (name.find('.') != std::string::npos || known.contains(name) || pruned_.contains(name) || unfinished)
      continue;
    (new_tables_ ? doubtful : report_.healed)
        .push_back(
            absl::StrCat(result_path(data_dir_, name).string(), " has results of a job that is not known"));
  }
  const absl::StatusOr<std::vector<std::string>> blobs = disk_.list(data_dir_ / "blobs");
  if (!blobs.ok()) return blobs.status();
  if (new_tables_ && !expected_ && ids.empty() && !blobs->empty()) {
    report_.lost.push_back(absl::StrCat((data_dir_ / "blobs").string(), " is full, but no job is known"));
  }
  return absl::OkStatus();
}

/// Whether all that lies behind the last commit may be of one that was under way when the coordinator ended.
bool LogRecovery::may_be_torn() const {
  return !new_tables_ && !(expected_ && expected_->commit > report_.counts.commit);
}

/// Whether nothing is left of a job but what was written of its submission then.
bool LogRecovery::is_unfinished(const Tail& tail) const {
  return tail.end == 0 && !tail.job.empty() && may_be_torn() && !is_damaged(tail.job);
}

bool LogRecovery::is_damaged(const std::string& job) const {
  return std::find(damaged_.begin(), damaged_.end(), job) != damaged_.end();
}

absl::Status LogRecovery::complete_logs() {
  // The farm's log need not know of deleted jobs any more.
  if (!pruned_.empty()) incomplete_.push_back("");
  for (const std::string& job : damaged_) {
    if (absl::Status status = disk_.move(path_of(job), path_of(job).string() + ".damaged"); !status.ok())
      return status;
  }
  for (const Tail& tail : tails_) {
    if (is_unfinished(tail)) {
      pruned_.insert(tail.job);
      continue;
    }
    if (tail.end == tail.size || is_damaged(tail.job)) continue;
    const auto file = disk_.open(path_of(tail.job), /*create=*/true);
    absl::Status status = file.ok() ? (*file)->truncate(tail.end) : file.status();
    if (status.ok()) status = (*file)->sync();
    if (!status.ok()) return status;
  }
  for (const std::string& job : pruned_) {
    absl::Status status = disk_.remove(result_path(data_dir_, job));
    status.Update(disk_.remove(path_of(job)));
    if (!status.ok()) return status;
  }
  for (const std::string& job : incomplete_) {
    const absl::StatusOr<std::uint64_t> bytes = write_anew(job);
    if (!bytes.ok()) return bytes.status();
    tables_.write_log(job, *bytes);
  }
  if (!report_.changed) return absl::OkStatus();
  absl::Status status = disk_.sync_directory(data_dir_ / "results");
  status.Update(disk_.sync_directory(data_dir_));
  return status;
}

absl::StatusOr<std::uint64_t> LogRecovery::write_anew(const std::string& job) {
  std::vector<LoggedEntry> entries;
  const auto add = [&](JournalEntry entry, std::uint64_t end = 0) {
    entries.push_back({.entry = std::move(entry), .payload = {.end = end}});
  };
  if (std::optional<JobRecord> record = job.empty() ? std::nullopt : rows_.job(job)) {
    add(record->added);
    if (!record->isa.empty()) add(JobBound{.id = job, .isa = record->isa});
    const absl::StatusOr<std::vector<std::uint64_t>> ends = rows_.read_results(*record, /*known=*/0);
    if (!ends.ok()) return ends.status();
    for (std::size_t i = 0; i < ends->size(); ++i) {
      JobRecord::Result& result = record->results[i];
      add(UnitDone{.job = job,
                   .sequence = i + 1,
                   .units = result.units,
                   .digest = result.digest,
                   .payload = "",
                   .stats = result.stats,
                   .host = result.host},
          (*ends)[i]);
    }
    if (record->stats.results > 0) add(record->stats);
    if (record->ended.state != 0) add(record->ended);
    if (record->fetched) add(JobFetched{.id = job});
  }
  for (SchedulerEvent& event : rows_.events(job)) add(std::move(event));

  if (absl::Status status = disk_.remove(path_of(job)); !status.ok()) return status;
  EntryLog log(disk_, path_of(job), 0);
  const CommitStamp stamp{.commit = report_.counts.commit,
                          .epoch = static_cast<std::uint32_t>(report_.counts.epoch)};
  absl::Status status = log.open();
  for (const LoggedEntry& logged : entries) log.append(stamp, logged.entry, logged.payload);
  status.Update(log.flush());
  if (status.ok()) status = log.file_to_sync()->sync();
  if (!status.ok()) return status;
  return log.appended_bytes();
}

}  // namespace tessera::server
