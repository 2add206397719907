#include "store/journal.h"

#include <algorithm>
#include <utility>

#include "absl/container/flat_hash_set.h"
#include "absl/strings/str_cat.h"
#include "store/log/checksum.h"
#include "store/sqlite/sqlite_journal.h"
#include "store/sqlite/sqlite_status.h"
#include "telemetry/log.h"
#include "tessera/v1/job.pb.h"

namespace tessera::server {
namespace {

// Results whose places are read at a time, of jobs that are over.
constexpr std::uint64_t kIndexPage = 1024;

// Pages of SQLite's log (WAL) beyond which it is copied into the database.
constexpr int kCheckpointPages = 1000;

// The manifest survives the process with each commit, and the machine with one of so many.
constexpr std::uint64_t kCommitsPerManifestSync = 16;

/// Whether nothing can be added to the job any more. An incomplete one may be opened again.
bool is_over(int state) { return state != 0 && state != v1::INCOMPLETE; }

}  // namespace

template <typename Function>
absl::Status SqliteJournal::read_tables(const char* what, Function function) {
  absl::Status status = guarded(what, function);
  if (absl::IsDataLoss(status) && manifest_ && counts_.damaged == 0) {
    counts_.damaged = 1;
    absl::Status noted = manifest_->write(counts_);
    if (noted.ok()) noted = manifest_->file_to_sync().sync();
    spdlog::error("the journal is damaged{}",
                  noted.ok() ? "; the next start makes it anew from the logs" : "");
  }
  return status;
}

absl::Status SqliteJournal::recover(const std::function<absl::Status(JobRecord)>& visit) {
  const std::lock_guard lock(database_mutex_);
  return read_tables("recovery", [&] {
    return rows_.jobs([&](JobRecord record) {
      const absl::Status status = recover_job(record);
      return status.ok() ? visit(std::move(record)) : status;
    });
  });
}

absl::StatusOr<JobRecord> SqliteJournal::read_job(const std::string& job) {
  const std::lock_guard lock(database_mutex_);
  std::optional<JobRecord> record;
  const absl::Status status = read_tables("reading", [&]() -> absl::Status {
    record = rows_.job(job);
    if (!record) return absl::NotFoundError(absl::StrCat("there is no job ", job));
    return rows_.read_results(*record, /*known=*/0).status();
  });
  if (!status.ok()) return status;
  return *std::move(record);
}

absl::Status SqliteJournal::recover_job(JobRecord& record) {
  const std::string& id = record.added.id;
  std::shared_ptr<ResultFile> file;
  rows_.count_results(record);
  if (is_over(record.ended.state) && record.stats.results == record.result_count) {
    record.events = rows_.events(id);
    file = std::make_shared<ResultFile>(disk_, path_of(id), record.result_count, record.result_bytes);
    record.whole_results = file->holds(record.result_bytes) ? record.result_count : 0;
  } else {
    absl::StatusOr<std::vector<std::uint64_t>> ends = rows_.read_results(record, record.stats.results);
    if (!ends.ok()) return ends.status();
    file = std::make_shared<ResultFile>(disk_, path_of(id), *std::move(ends));
    record.whole_results = file->whole_results();
    if (is_over(record.ended.state)) file->forget_ends();
  }
  if (record.result_count == 0) return absl::OkStatus();
  results_[id] = file;
  return absl::OkStatus();
}

absl::Status SqliteJournal::commit(const std::vector<JournalEntry>& entries) {
  const std::lock_guard lock(database_mutex_);
  if (!health_.ok()) return health_;
  // The files first: a row must never point to bytes that are not on the disk.
  std::vector<PayloadPlace> places(entries.size());
  health_ = guarded("commit", [&] {
    absl::Status status = write_files(entries, places);
    if (status.ok()) write_rows(entries, places);
    return status;
  });
  if (!health_.ok()) {
    if (logs_) logs_->drop();
    return health_;
  }
  if (logs_) logs_->keep();
  ++counts_.commit;
  for (std::size_t i = 0; i < entries.size(); ++i) put_in_effect(entries[i], places[i].end);
  if (manifest_) health_ = manifest_->write(counts_);
  if (health_.ok() && manifest_ && wal_pages_ >= kCheckpointPages) health_ = checkpoint();
  return health_;
}

absl::Status SqliteJournal::checkpoint() {
  counts_.checkpoint = counts_.commit;
  absl::Status status = manifest_->write(counts_);
  if (status.ok()) status = manifest_->file_to_sync().sync();
  if (!status.ok()) return status;
  return guarded("checkpoint", [&] {
    if (sqlite3_wal_checkpoint_v2(database_.getHandle(), "main", SQLITE_CHECKPOINT_TRUNCATE, nullptr,
                                  nullptr) != SQLITE_OK) {
      throw SQLite::Exception(database_.getHandle());
    }
    wal_pages_ = 0;
    return absl::OkStatus();
  });
}

/// Consequences of an entry that is durable.
void SqliteJournal::put_in_effect(const JournalEntry& entry, std::uint64_t end) {
  if (std::holds_alternative<JobAdded>(entry)) ++counts_.jobs;
  if (const auto* const unit = std::get_if<UnitDone>(&entry)) {
    ++counts_.results;
    results_of(unit->job)->keep(end);
  }
  if (const auto* const ended = std::get_if<JobEnded>(&entry)) {
    const std::shared_ptr<ResultFile> file = results_of(ended->id);
    file->close();
    if (is_over(ended->state)) file->forget_ends();
    if (logs_) logs_->close(ended->id);
  }
  if (const auto* const pruned = std::get_if<JobPruned>(&entry)) {
    --counts_.jobs;
    {
      const std::lock_guard lock(results_mutex_);
      results_.erase(pruned->id);
    }
    // Files that stay behind after a crash or an error are deleted by the next start.
    if (!data_dir_.empty()) static_cast<void>(disk_.remove(path_of(pruned->id)));
    if (logs_) logs_->remove(pruned->id);
  }
}

absl::StatusOr<std::vector<SchedulerEvent>> SqliteJournal::farm_events() {
  const std::lock_guard lock(database_mutex_);
  std::vector<SchedulerEvent> events;
  const absl::Status status = read_tables("recovery", [&] {
    events = rows_.events("");
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  return events;
}

/// Payloads, and the entries in their logs: durable when it returns OK.
absl::Status SqliteJournal::write_files(const std::vector<JournalEntry>& entries,
                                        std::vector<PayloadPlace>& places) {
  std::vector<DiskFile*> files;
  absl::StatusOr<bool> made_file = write_payloads(entries, places, files);
  if (!made_file.ok()) return made_file.status();
  if (logs_) {
    const CommitStamp stamp{.commit = counts_.commit + 1, .epoch = static_cast<std::uint32_t>(epoch_)};
    if (absl::Status status = logs_->append(stamp, entries, places); !status.ok()) return status;
    for (DiskFile* const file : logs_->files_to_sync()) files.push_back(file);
    if (stamp.commit % kCommitsPerManifestSync == 0) files.push_back(&manifest_->file_to_sync());
  }
  if (absl::Status status = disk_.sync(files); !status.ok()) return status;
  return *made_file && !data_dir_.empty() ? disk_.sync_directory(data_dir_ / "results") : absl::OkStatus();
}

/// Whether a file was made, and what has to be synced.
absl::StatusOr<bool> SqliteJournal::write_payloads(const std::vector<JournalEntry>& entries,
                                                   std::vector<PayloadPlace>& places,
                                                   std::vector<DiskFile*>& files) {
  absl::flat_hash_set<std::shared_ptr<ResultFile>> touched;
  bool made_file = false;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    made_file |= std::holds_alternative<JobAdded>(entries[i]);  // its log
    const auto* const unit = std::get_if<UnitDone>(&entries[i]);
    if (unit == nullptr) continue;
    const std::shared_ptr<ResultFile> file = results_of(unit->job);
    absl::StatusOr<std::string> copy = std::string();
    if (!unit->from_job.empty()) {
      const std::shared_ptr<ResultFile> from = results_of(unit->from_job);
      const absl::StatusOr<ResultFile::Extent> extent =
          find_result(unit->from_job, unit->from_sequence, *from);
      copy = extent.ok() ? from->read(*extent) : extent.status();
    }
    // A copy of what is lost is as lost: noticed, and done again, when somebody reads it.
    if (absl::IsDataLoss(copy.status()) || absl::IsNotFound(copy.status())) copy = std::string();
    if (!copy.ok()) return copy.status();
    const std::string& payload = unit->from_job.empty() ? unit->payload : *copy;
    const absl::StatusOr<std::uint64_t> end = file->append(payload);
    if (!end.ok()) return end.status();
    places[i] = {.end = *end, .bytes = payload.size(), .sum = logs_ ? checksum(payload, 0) : 0};
    made_file |= unit->sequence == 1;
    touched.insert(file);
  }
  // Files of results are kept open while their job is, and so until they are synced.
  for (const std::shared_ptr<ResultFile>& file : touched) {
    if (DiskFile* const to_sync = file->file_to_sync()) files.push_back(to_sync);
  }
  return made_file;
}

void SqliteJournal::write_rows(const std::vector<JournalEntry>& entries,
                               const std::vector<PayloadPlace>& places) {
  SQLite::Transaction transaction(database_);
  std::uint64_t deleted_results = 0;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (const auto* const pruned = std::get_if<JobPruned>(&entries[i]))
      deleted_results += rows_.result_count(pruned->id);
    tables_->write(entries[i], places[i].end);
  }
  if (logs_) {
    logs_->write_reach(*tables_);
    tables_->write_commit(counts_.commit + 1);
  }
  transaction.commit();
  counts_.results -= deleted_results;
}

std::shared_ptr<ResultFile> SqliteJournal::results_of(const std::string& job) {
  const std::lock_guard lock(results_mutex_);
  std::shared_ptr<ResultFile>& file = results_[job];
  if (file == nullptr) file = std::make_shared<ResultFile>(disk_, path_of(job), std::vector<std::uint64_t>{});
  return file;
}

absl::StatusOr<std::string> SqliteJournal::read_result(const std::string& job, std::uint64_t sequence) {
  const std::shared_ptr<ResultFile> file = results_of(job);
  const absl::StatusOr<std::optional<ResultFile::Extent>> known = file->extent(sequence);
  if (!known.ok()) return known.status();
  if (*known) return file->read(**known);
  absl::StatusOr<ResultFile::Extent> found;
  {
    const std::lock_guard lock(database_mutex_);
    const absl::Status status = read_tables("reading", [&] {
      found = find_result(job, sequence, *file);
      return found.status();
    });
    if (!status.ok()) return status;
  }
  return file->read(*found);
}

/// Where a result is; of a job that is over, with those around it.
absl::StatusOr<ResultFile::Extent> SqliteJournal::find_result(const std::string& job, std::uint64_t sequence,
                                                              ResultFile& file) {
  const absl::StatusOr<std::optional<ResultFile::Extent>> known = file.extent(sequence);
  if (!known.ok()) return known.status();
  if (*known) return **known;
  const std::uint64_t before = (sequence - 1) / kIndexPage * kIndexPage;
  std::vector<std::uint64_t> ends = rows_.ends(job, before, before + kIndexPage);
  std::uint64_t begin = 0;
  if (before > 0 && !ends.empty()) {
    begin = ends.front();
    ends.erase(ends.begin());
  }
  const std::uint64_t i = sequence - before - 1;
  if (i >= ends.size() || !std::is_sorted(ends.begin(), ends.end()) || ends.front() < begin) {
    return absl::DataLossError(absl::StrCat("journal: job ", job, " lacks result ", sequence));
  }
  const ResultFile::Extent extent{.begin = i == 0 ? begin : ends[i - 1], .end = ends[i]};
  file.remember_ends(before, begin, std::move(ends));
  return extent;
}

absl::StatusOr<std::vector<CoveredUnits>> SqliteJournal::read_units(const std::string& job,
                                                                    std::uint64_t after, std::uint32_t most) {
  const std::lock_guard lock(database_mutex_);
  std::vector<CoveredUnits> units;
  const absl::Status status = read_tables("reading", [&] {
    units = rows_.units(job, after, most);
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  return units;
}

absl::StatusOr<std::vector<std::string>> SqliteJournal::read_stats(const std::string& job,
                                                                   std::uint64_t after, std::uint32_t most) {
  const std::lock_guard lock(database_mutex_);
  std::vector<std::string> stats;
  const absl::Status status = read_tables("reading", [&] {
    stats = rows_.stats(job, after, most);
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  return stats;
}

}  // namespace tessera::server
