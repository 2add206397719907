#include "store/sqlite/journal_tables.h"

#include <variant>

#include "absl/strings/str_cat.h"

namespace tessera::server {
namespace {

// Nothing reads others.
constexpr int kFormatVersion = 5;

constexpr char kSchema[] = R"(
  CREATE TABLE IF NOT EXISTS meta (key TEXT PRIMARY KEY, value INTEGER NOT NULL) WITHOUT ROWID;
  CREATE TABLE IF NOT EXISTS jobs (
    number INTEGER PRIMARY KEY,
    id TEXT NOT NULL UNIQUE,
    request_id TEXT NOT NULL UNIQUE,
    spec BLOB NOT NULL,
    generation INTEGER NOT NULL,
    submitted_unix_ms INTEGER NOT NULL,
    uploaded_bytes INTEGER NOT NULL,
    isa TEXT NOT NULL DEFAULT '',
    state INTEGER NOT NULL DEFAULT 0,
    error TEXT NOT NULL DEFAULT '',
    finished_unix_ms INTEGER NOT NULL DEFAULT 0,
    fetched INTEGER NOT NULL DEFAULT 0,
    stats BLOB NOT NULL DEFAULT x'',
    stats_results INTEGER NOT NULL DEFAULT 0);
  CREATE TABLE IF NOT EXISTS results (
    job TEXT NOT NULL,
    sequence INTEGER NOT NULL,
    unit INTEGER NOT NULL,
    digest TEXT NOT NULL,
    end INTEGER NOT NULL,  -- of the payload within the job's result file
    stats BLOB NOT NULL,
    host TEXT NOT NULL,
    ranges INTEGER NOT NULL,
    PRIMARY KEY (job, sequence)) WITHOUT ROWID;
  CREATE TABLE IF NOT EXISTS events (
    number INTEGER PRIMARY KEY,
    job TEXT NOT NULL,
    kind INTEGER NOT NULL,
    unit INTEGER NOT NULL,
    value INTEGER NOT NULL,
    host TEXT NOT NULL,
    text TEXT NOT NULL);
  CREATE INDEX IF NOT EXISTS events_by_job ON events (job);
  CREATE TABLE IF NOT EXISTS logs (
    job TEXT PRIMARY KEY,     -- empty: the farm's
    bytes INTEGER NOT NULL    -- of its log, that the tables have
  ) WITHOUT ROWID;
)";

}  // namespace

absl::Status JournalTables::prepare(SQLite::Database& database) {
  database.exec(kSchema);
  SQLite::Transaction transaction(database);
  database.exec(absl::StrCat("INSERT OR IGNORE INTO meta VALUES ('format', ", kFormatVersion,
                             "), ('epoch', 0), ('commit', 0)"));
  const int format = database.execAndGet("SELECT value FROM meta WHERE key = 'format'").getInt();
  if (format != kFormatVersion) {
    return absl::FailedPreconditionError(absl::StrCat(
        "the journal has format ", format, "; this version knows format ", kFormatVersion, " alone"));
  }
  transaction.commit();
  return absl::OkStatus();
}

std::uint64_t JournalTables::begin_epoch(SQLite::Database& database, std::uint64_t past) {
  SQLite::Statement update(database, "UPDATE meta SET value = MAX(value, ?) + 1 WHERE key = 'epoch'");
  update.bind(1, static_cast<std::int64_t>(past));
  update.exec();
  return static_cast<std::uint64_t>(
      database.execAndGet("SELECT value FROM meta WHERE key = 'epoch'").getInt64());
}

JournalTables::JournalTables(SQLite::Database& database)
    : add_(database,
           "INSERT INTO jobs (id, request_id, spec, generation, submitted_unix_ms, uploaded_bytes) "
           "VALUES (?, ?, ?, ?, ?, ?)"),
      bind_(database, "UPDATE jobs SET isa = ? WHERE id = ?"),
      end_(database, "UPDATE jobs SET state = ?, error = ?, finished_unix_ms = ? WHERE id = ?"),
      done_(database, "INSERT INTO results VALUES (?, ?, ?, ?, ?, ?, ?, ?)"),
      stats_(database, "UPDATE jobs SET stats = ?, stats_results = ? WHERE id = ?"),
      event_(database, "INSERT INTO events (job, kind, unit, value, host, text) VALUES (?, ?, ?, ?, ?, ?)"),
      fetched_(database, "UPDATE jobs SET fetched = 1 WHERE id = ?"),
      prune_job_(database, "DELETE FROM jobs WHERE id = ?"),
      prune_results_(database, "DELETE FROM results WHERE job = ?"),
      prune_events_(database, "DELETE FROM events WHERE job = ?"),
      log_(database, "INSERT OR REPLACE INTO logs VALUES (?, ?)"),
      forget_log_(database, "DELETE FROM logs WHERE job = ?"),
      commit_(database, "UPDATE meta SET value = ? WHERE key = 'commit'") {}

void JournalTables::write(const JournalEntry& entry, std::uint64_t end) {
  std::visit([&](const auto& row) { write_row(row, end); }, entry);
}

void JournalTables::write_log(const std::string& job, std::uint64_t bytes) {
  log_.reset();
  log_.bind(1, job);
  log_.bind(2, static_cast<std::int64_t>(bytes));
  log_.exec();
}

void JournalTables::forget_log(const std::string& job) {
  forget_log_.reset();
  forget_log_.bind(1, job);
  forget_log_.exec();
}

void JournalTables::write_commit(std::uint64_t commit) {
  commit_.reset();
  commit_.bind(1, static_cast<std::int64_t>(commit));
  commit_.exec();
}

void JournalTables::write_row(const JobAdded& entry, std::uint64_t) {
  SQLite::Statement& row = add_;
  row.reset();
  row.bind(1, entry.id);
  row.bind(2, entry.request_id);
  row.bind(3, entry.spec.data(), static_cast<int>(entry.spec.size()));
  row.bind(4, entry.generation);
  row.bind(5, entry.submitted_unix_ms);
  row.bind(6, static_cast<std::int64_t>(entry.uploaded_bytes));
  row.exec();
}

void JournalTables::write_row(const JobBound& entry, std::uint64_t) {
  SQLite::Statement& row = bind_;
  row.reset();
  row.bind(1, entry.isa);
  row.bind(2, entry.id);
  row.exec();
}

void JournalTables::write_row(const JobEnded& entry, std::uint64_t) {
  SQLite::Statement& row = end_;
  row.reset();
  row.bind(1, entry.state);
  row.bind(2, entry.error);
  row.bind(3, entry.finished_unix_ms);
  row.bind(4, entry.id);
  row.exec();
}

void JournalTables::write_row(const UnitDone& entry, std::uint64_t end) {
  SQLite::Statement& row = done_;
  row.reset();
  row.bind(1, entry.job);
  row.bind(2, static_cast<std::int64_t>(entry.sequence));
  row.bind(3, entry.units.first);
  row.bind(4, entry.digest);
  row.bind(5, static_cast<std::int64_t>(end));
  row.bind(6, entry.stats.data(), static_cast<int>(entry.stats.size()));
  row.bind(7, entry.host);
  row.bind(8, entry.units.ranges);
  row.exec();
}

void JournalTables::write_row(const JobStats& entry, std::uint64_t) {
  SQLite::Statement& row = stats_;
  row.reset();
  row.bind(1, entry.stats.data(), static_cast<int>(entry.stats.size()));
  row.bind(2, static_cast<std::int64_t>(entry.results));
  row.bind(3, entry.id);
  row.exec();
}

void JournalTables::write_row(const SchedulerEvent& entry, std::uint64_t) {
  SQLite::Statement& row = event_;
  row.reset();
  row.bind(1, entry.job);
  row.bind(2, entry.kind);
  row.bind(3, entry.unit);
  row.bind(4, entry.value);
  row.bind(5, entry.host);
  row.bind(6, entry.text);
  row.exec();
}

void JournalTables::write_row(const JobReopened& entry, std::uint64_t end) {
  write_row(JobEnded{.id = entry.id, .state = 0, .error = "", .finished_unix_ms = 0}, end);
}

void JournalTables::write_row(const JobFetched& entry, std::uint64_t) {
  fetched_.reset();
  fetched_.bind(1, entry.id);
  fetched_.exec();
}

void JournalTables::write_row(const JobPruned& entry, std::uint64_t) {
  for (SQLite::Statement* const row : {&prune_job_, &prune_results_, &prune_events_, &forget_log_}) {
    row->reset();
    row->bind(1, entry.id);
    row->exec();
  }
}

}  // namespace tessera::server
