#include "store/journal.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <sqlite3.h>

#include <algorithm>
#include <mutex>
#include <optional>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/strings/str_cat.h"
#include "store/checked_pages.h"
#include "store/journal_tables.h"
#include "store/result_file.h"
#include "tessera/v1/job.pb.h"

namespace tessera::server {
namespace {

// Results whose places are read at a time, of jobs that are over.
constexpr std::uint64_t kIndexPage = 1024;

std::string text(const SQLite::Column& column) { return column.getString(); }

/// The coordinator's one writer; readers only touch result files.
class SqliteJournal final : public Journal {
 public:
  /// Throws SQLite::Exception.
  SqliteJournal(const std::filesystem::path& data_dir, Disk& disk)
      : data_dir_(data_dir),
        disk_(disk),
        database_(data_dir.empty() ? ":memory:" : (data_dir / "journal.sqlite").string(),
                  SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE, /*busyTimeoutMs=*/0, disk.sqlite_vfs()) {
    // The data directory is this process's alone (data_dir.h), so nobody else needs to see the index of the log.
    database_.exec("PRAGMA locking_mode = EXCLUSIVE");
    database_.execAndGet("PRAGMA schema_version");  // reads the first page: damage there is to be called so
    if (!data_dir.empty() && disk.sqlite_vfs() == checked_pages_vfs() &&
        make_room_for_checksums(database_.getHandle()) != SQLITE_OK) {
      throw SQLite::Exception(database_.getHandle());
    }
    database_.exec("PRAGMA journal_mode = WAL");
    database_.exec("PRAGMA synchronous = FULL");
  }

  /// Begins a new epoch. Throws SQLite::Exception.
  absl::Status begin() {
    const absl::StatusOr<std::uint64_t> epoch = JournalTables::begin_epoch(database_);
    if (!epoch.ok()) {
      return absl::Status(epoch.status().code(),
                          absl::StrCat(data_dir_.string(), ": ", std::string(epoch.status().message())));
    }
    epoch_ = *epoch;
    tables_.emplace(database_);
    return absl::OkStatus();
  }

  std::uint64_t epoch() const override { return epoch_; }
  absl::Status recover(const std::function<absl::Status(JobRecord)>& visit) override;
  absl::StatusOr<JobRecord> read_job(const std::string& job) override;
  absl::StatusOr<std::vector<SchedulerEvent>> farm_events() override;
  absl::Status commit(const std::vector<JournalEntry>& entries) override;
  absl::StatusOr<std::string> read_result(const std::string& job, std::uint64_t sequence) override;
  absl::StatusOr<std::vector<std::uint32_t>> read_units(const std::string& job, std::uint64_t after,
                                                        std::uint32_t most) override;

 private:
  static JobRecord read_row(SQLite::Statement& jobs);
  /// `known`: of so many results the costs are not needed.
  absl::StatusOr<std::vector<std::uint64_t>> read_results(JobRecord& record, std::uint64_t known);
  absl::Status recover_job(JobRecord& record);
  std::shared_ptr<ResultFile> results_of(const std::string& job);
  // With database_mutex_ held.
  void count_results(JobRecord& record);
  absl::StatusOr<ResultFile::Extent> find_result(const std::string& job, std::uint64_t sequence, ResultFile& file);
  absl::Status write_payloads(const std::vector<JournalEntry>& entries, std::vector<std::uint64_t>& ends);
  void write_rows(const std::vector<JournalEntry>& entries, const std::vector<std::uint64_t>& ends);
  std::vector<SchedulerEvent> read_events(const std::string& job);
  void put_in_effect(const JournalEntry& entry, std::uint64_t end);

  std::filesystem::path result_path(const std::string& job) const {
    return data_dir_.empty() ? std::filesystem::path() : data_dir_ / "results" / job;
  }

  std::filesystem::path data_dir_;
  Disk& disk_;
  std::uint64_t epoch_ = 0;

  std::mutex database_mutex_;
  SQLite::Database database_;
  std::optional<JournalTables> tables_;
  absl::Status health_;  // the first error of a commit

  std::mutex results_mutex_;
  absl::flat_hash_map<std::string, std::shared_ptr<ResultFile>> results_;
};

// SQLiteCpp speaks in exceptions; they end here.
template <typename Function>
absl::Status guarded(const char* what, Function function) {
  try {
    return function();
  } catch (const SQLite::Exception& error) {
    const std::string message = absl::StrCat("journal, ", what, ": ", error.what());
    if (error.getExtendedErrorCode() == SQLITE_IOERR_DATA) {
      return absl::DataLossError(absl::StrCat(message, ": a page does not have its checksum, so the file is damaged"));
    }
    switch (error.getErrorCode()) {
      case SQLITE_FULL:
        return absl::ResourceExhaustedError(message);
      case SQLITE_CORRUPT:
      case SQLITE_NOTADB:
        return absl::DataLossError(message);
      default:
        return absl::InternalError(message);
    }
  }
}

constexpr char kJobColumns[] =
    "SELECT id, request_id, spec, generation, submitted_unix_ms, uploaded_bytes, isa, state, error, finished_unix_ms, "
    "fetched, stats, stats_results FROM jobs ";

/// Whether nothing can be added to the job any more. An incomplete one may be opened again.
bool is_over(int state) { return state != 0 && state != v1::INCOMPLETE; }

absl::Status SqliteJournal::recover(const std::function<absl::Status(JobRecord)>& visit) {
  const std::lock_guard lock(database_mutex_);
  return guarded("recovery", [&]() -> absl::Status {
    SQLite::Statement jobs(database_, std::string(kJobColumns) + "ORDER BY number");
    while (jobs.executeStep()) {
      JobRecord record = read_row(jobs);
      if (absl::Status status = recover_job(record); !status.ok()) return status;
      if (absl::Status status = visit(std::move(record)); !status.ok()) return status;
    }
    return absl::OkStatus();
  });
}

absl::StatusOr<JobRecord> SqliteJournal::read_job(const std::string& job) {
  const std::lock_guard lock(database_mutex_);
  JobRecord record;
  const absl::Status status = guarded("reading", [&]() -> absl::Status {
    SQLite::Statement jobs(database_, std::string(kJobColumns) + "WHERE id = ?");
    jobs.bind(1, job);
    if (!jobs.executeStep()) return absl::NotFoundError(absl::StrCat("there is no job ", job));
    record = read_row(jobs);
    return read_results(record, /*known=*/0).status();
  });
  if (!status.ok()) return status;
  return record;
}

/// All but results and events.
JobRecord SqliteJournal::read_row(SQLite::Statement& jobs) {
  JobRecord record;
  record.added = {.id = text(jobs.getColumn(0)),
                  .request_id = text(jobs.getColumn(1)),
                  .spec = text(jobs.getColumn(2)),
                  .generation = jobs.getColumn(3).getUInt(),
                  .submitted_unix_ms = jobs.getColumn(4).getInt64(),
                  .uploaded_bytes = static_cast<std::uint64_t>(jobs.getColumn(5).getInt64())};
  record.isa = text(jobs.getColumn(6));
  record.ended = {.id = record.added.id,
                  .state = jobs.getColumn(7).getInt(),
                  .error = text(jobs.getColumn(8)),
                  .finished_unix_ms = jobs.getColumn(9).getInt64()};
  record.fetched = jobs.getColumn(10).getInt() != 0;
  record.stats = {.id = record.added.id,
                  .results = static_cast<std::uint64_t>(jobs.getColumn(12).getInt64()),
                  .stats = text(jobs.getColumn(11))};
  return record;
}

/// Results and events; returns where the payloads end.
absl::StatusOr<std::vector<std::uint64_t>> SqliteJournal::read_results(JobRecord& record, std::uint64_t known) {
  SQLite::Statement rows(
      database_, "SELECT sequence, unit, digest, end, stats, host FROM results WHERE job = ? ORDER BY sequence");
  rows.bind(1, record.added.id);
  record.events = read_events(record.added.id);
  std::vector<std::uint64_t> ends;
  while (rows.executeStep()) {
    const std::int64_t sequence = rows.getColumn(0).getInt64();
    const std::int64_t end = rows.getColumn(3).getInt64();
    const std::uint64_t begin = ends.empty() ? 0 : ends.back();
    if (sequence != static_cast<std::int64_t>(ends.size()) + 1 || end < 0 || static_cast<std::uint64_t>(end) < begin) {
      return absl::DataLossError(absl::StrCat("journal: job ", record.added.id, " lacks result ", ends.size() + 1));
    }
    ends.push_back(static_cast<std::uint64_t>(end));
    record.results.push_back({.unit = rows.getColumn(1).getUInt(),
                              .digest = text(rows.getColumn(2)),
                              .stats = ends.size() > known ? text(rows.getColumn(4)) : "",
                              .host = text(rows.getColumn(5)),
                              .bytes = ends.back() - begin});
  }
  record.result_bytes = ends.empty() ? 0 : ends.back();
  record.result_count = ends.size();
  return ends;
}

void SqliteJournal::count_results(JobRecord& record) {
  SQLite::Statement last(database_, "SELECT sequence, end FROM results WHERE job = ? ORDER BY sequence DESC LIMIT 1");
  last.bind(1, record.added.id);
  if (!last.executeStep()) return;
  record.result_count = static_cast<std::uint64_t>(last.getColumn(0).getInt64());
  record.result_bytes = static_cast<std::uint64_t>(last.getColumn(1).getInt64());
}

absl::Status SqliteJournal::recover_job(JobRecord& record) {
  const std::string& id = record.added.id;
  std::shared_ptr<ResultFile> file;
  count_results(record);
  if (is_over(record.ended.state) && record.stats.results == record.result_count) {
    record.events = read_events(id);
    file = std::make_shared<ResultFile>(disk_, result_path(id), record.result_count, record.result_bytes);
    record.whole_results = record.result_count;  // what is not, is noticed when it is read
  } else {
    absl::StatusOr<std::vector<std::uint64_t>> ends = read_results(record, record.stats.results);
    if (!ends.ok()) return ends.status();
    file = std::make_shared<ResultFile>(disk_, result_path(id), *std::move(ends));
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
  // The payloads first: a row must never point to bytes that are not on the disk.
  std::vector<std::uint64_t> ends(entries.size(), 0);
  health_ = write_payloads(entries, ends);
  if (health_.ok()) {
    health_ = guarded("commit", [&] {
      write_rows(entries, ends);
      return absl::OkStatus();
    });
  }
  if (!health_.ok()) return health_;
  for (std::size_t i = 0; i < entries.size(); ++i) put_in_effect(entries[i], ends[i]);
  return absl::OkStatus();
}

/// What follows from an entry that is durable.
void SqliteJournal::put_in_effect(const JournalEntry& entry, std::uint64_t end) {
  if (const auto* const unit = std::get_if<UnitDone>(&entry)) results_of(unit->job)->keep(end);
  if (const auto* const ended = std::get_if<JobEnded>(&entry)) {
    const std::shared_ptr<ResultFile> file = results_of(ended->id);
    file->close();
    if (is_over(ended->state)) file->forget_ends();
  }
  if (const auto* const pruned = std::get_if<JobPruned>(&entry)) {
    {
      const std::lock_guard lock(results_mutex_);
      results_.erase(pruned->id);
    }
    // A file that stays behind after a crash or an error costs space, and nothing else.
    if (!data_dir_.empty()) static_cast<void>(disk_.remove(result_path(pruned->id)));
  }
}

absl::StatusOr<std::vector<SchedulerEvent>> SqliteJournal::farm_events() {
  const std::lock_guard lock(database_mutex_);
  std::vector<SchedulerEvent> events;
  const absl::Status status = guarded("recovery", [&] {
    events = read_events("");
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  return events;
}

std::vector<SchedulerEvent> SqliteJournal::read_events(const std::string& job) {
  SQLite::Statement rows(database_, "SELECT kind, unit, value, host, text FROM events WHERE job = ? ORDER BY number");
  rows.bind(1, job);
  std::vector<SchedulerEvent> events;
  while (rows.executeStep()) {
    events.push_back({.job = job,
                      .kind = rows.getColumn(0).getInt(),
                      .unit = rows.getColumn(1).getUInt(),
                      .value = rows.getColumn(2).getInt64(),
                      .host = text(rows.getColumn(3)),
                      .text = text(rows.getColumn(4))});
  }
  return events;
}

absl::Status SqliteJournal::write_payloads(const std::vector<JournalEntry>& entries, std::vector<std::uint64_t>& ends) {
  absl::flat_hash_set<std::shared_ptr<ResultFile>> touched;
  bool made_file = false;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const auto* const unit = std::get_if<UnitDone>(&entries[i]);
    if (unit == nullptr) continue;
    const std::shared_ptr<ResultFile> file = results_of(unit->job);
    absl::StatusOr<std::string> copy = std::string();
    if (!unit->from_job.empty()) {
      const std::shared_ptr<ResultFile> from = results_of(unit->from_job);
      const absl::StatusOr<ResultFile::Extent> extent = find_result(unit->from_job, unit->from_sequence, *from);
      copy = extent.ok() ? from->read(*extent) : extent.status();
    }
    // A copy of what is lost is as lost: noticed, and done again, when somebody reads it.
    if (absl::IsDataLoss(copy.status()) || absl::IsNotFound(copy.status())) copy = std::string();
    if (!copy.ok()) return copy.status();
    const absl::StatusOr<std::uint64_t> end = file->append(unit->from_job.empty() ? unit->payload : *copy);
    if (!end.ok()) return end.status();
    ends[i] = *end;
    made_file |= unit->sequence == 1;
    touched.insert(file);
  }
  std::vector<DiskFile*> files;
  for (const std::shared_ptr<ResultFile>& file : touched) {
    if (DiskFile* const to_sync = file->file_to_sync()) files.push_back(to_sync);
  }
  if (absl::Status status = disk_.sync(files); !status.ok()) return status;
  return made_file && !data_dir_.empty() ? disk_.sync_directory(data_dir_ / "results") : absl::OkStatus();
}

void SqliteJournal::write_rows(const std::vector<JournalEntry>& entries, const std::vector<std::uint64_t>& ends) {
  SQLite::Transaction transaction(database_);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    tables_->write(entries[i], ends[i]);
  }
  transaction.commit();
}

std::shared_ptr<ResultFile> SqliteJournal::results_of(const std::string& job) {
  const std::lock_guard lock(results_mutex_);
  std::shared_ptr<ResultFile>& file = results_[job];
  if (file == nullptr) file = std::make_shared<ResultFile>(disk_, result_path(job), std::vector<std::uint64_t>{});
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
    const absl::Status status = guarded("reading", [&] {
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
  SQLite::Statement rows(database_,
                         "SELECT end FROM results WHERE job = ? AND sequence BETWEEN ? AND ? ORDER BY sequence");
  rows.bind(1, job);
  rows.bind(2, static_cast<std::int64_t>(before));
  rows.bind(3, static_cast<std::int64_t>(before + kIndexPage));
  std::uint64_t begin = 0;
  if (before > 0 && rows.executeStep()) begin = static_cast<std::uint64_t>(rows.getColumn(0).getInt64());
  std::vector<std::uint64_t> ends;
  while (rows.executeStep()) ends.push_back(static_cast<std::uint64_t>(rows.getColumn(0).getInt64()));
  const std::uint64_t i = sequence - before - 1;
  if (i >= ends.size() || !std::is_sorted(ends.begin(), ends.end()) || ends.front() < begin) {
    return absl::DataLossError(absl::StrCat("journal: job ", job, " lacks result ", sequence));
  }
  const ResultFile::Extent extent{.begin = i == 0 ? begin : ends[i - 1], .end = ends[i]};
  file.remember_ends(before, begin, std::move(ends));
  return extent;
}

absl::StatusOr<std::vector<std::uint32_t>> SqliteJournal::read_units(const std::string& job, std::uint64_t after,
                                                                     std::uint32_t most) {
  const std::lock_guard lock(database_mutex_);
  std::vector<std::uint32_t> units;
  const absl::Status status = guarded("reading", [&] {
    SQLite::Statement rows(database_,
                           "SELECT unit FROM results WHERE job = ? AND sequence > ? ORDER BY sequence LIMIT ?");
    rows.bind(1, job);
    rows.bind(2, static_cast<std::int64_t>(after));
    rows.bind(3, most);
    while (rows.executeStep()) units.push_back(rows.getColumn(0).getUInt());
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  return units;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Journal>> open_journal(const std::filesystem::path& data_dir, Disk& disk) {
  std::unique_ptr<SqliteJournal> journal;
  const absl::Status status = guarded("opening", [&] {
    journal = std::make_unique<SqliteJournal>(data_dir, disk);
    return journal->begin();
  });
  if (!status.ok()) return status;
  return journal;
}

}  // namespace tessera::server
