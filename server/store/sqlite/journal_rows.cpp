#include "store/sqlite/journal_rows.h"

#include "absl/strings/str_cat.h"

namespace tessera::server {
namespace {

constexpr char kJobColumns[] =
    "SELECT id, request_id, spec, generation, submitted_unix_ms, uploaded_bytes, isa, state, error, "
    "finished_unix_ms, "
    "fetched, stats, stats_results FROM jobs ";

std::string text(const SQLite::Column& column) { return column.getString(); }

JobRecord read_row(SQLite::Statement& jobs) {
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

}  // namespace

std::vector<std::string> JournalRows::ids() {
  SQLite::Statement rows(database_, "SELECT id FROM jobs ORDER BY number");
  std::vector<std::string> ids;
  while (rows.executeStep()) ids.push_back(text(rows.getColumn(0)));
  return ids;
}

std::optional<JobRecord> JournalRows::job(const std::string& id) {
  SQLite::Statement jobs(database_, std::string(kJobColumns) + "WHERE id = ?");
  jobs.bind(1, id);
  if (!jobs.executeStep()) return std::nullopt;
  return read_row(jobs);
}

absl::Status JournalRows::jobs(const std::function<absl::Status(JobRecord)>& visit) {
  SQLite::Statement jobs(database_, std::string(kJobColumns) + "ORDER BY number");
  absl::Status status;
  while (status.ok() && jobs.executeStep()) status = visit(read_row(jobs));
  return status;
}

std::uint64_t JournalRows::result_count(const std::string& job) {
  JobRecord record;
  record.added.id = job;
  count_results(record);
  return record.result_count;
}

void JournalRows::count_results(JobRecord& record) {
  SQLite::Statement last(database_,
                         "SELECT sequence, end FROM results WHERE job = ? ORDER BY sequence DESC LIMIT 1");
  last.bind(1, record.added.id);
  if (!last.executeStep()) return;
  record.result_count = static_cast<std::uint64_t>(last.getColumn(0).getInt64());
  record.result_bytes = static_cast<std::uint64_t>(last.getColumn(1).getInt64());
}

absl::StatusOr<std::vector<std::uint64_t>> JournalRows::read_results(JobRecord& record, std::uint64_t known) {
  SQLite::Statement rows(
      database_,
      "SELECT sequence, unit, digest, end, stats, host, ranges FROM results WHERE job = ? ORDER BY sequence");
  rows.bind(1, record.added.id);
  record.events = events(record.added.id);
  std::vector<std::uint64_t> ends;
  while (rows.executeStep()) {
    const std::int64_t sequence = rows.getColumn(0).getInt64();
    const std::int64_t end = rows.getColumn(3).getInt64();
    const std::uint64_t begin = ends.empty() ? 0 : ends.back();
    if (sequence != static_cast<std::int64_t>(ends.size()) + 1 || end < 0 ||
        static_cast<std::uint64_t>(end) < begin) {
      return absl::DataLossError(
          absl::StrCat("journal: job ", record.added.id, " lacks result ", ends.size() + 1));
    }
    ends.push_back(static_cast<std::uint64_t>(end));
    record.results.push_back(
        {.units = {.first = rows.getColumn(1).getUInt(), .ranges = rows.getColumn(6).getUInt()},
         .digest = text(rows.getColumn(2)),
         .stats = ends.size() > known ? text(rows.getColumn(4)) : "",
         .host = text(rows.getColumn(5)),
         .bytes = ends.back() - begin});
  }
  record.result_bytes = ends.empty() ? 0 : ends.back();
  record.result_count = ends.size();
  return ends;
}

std::vector<std::uint64_t> JournalRows::ends(const std::string& job, std::uint64_t first,
                                             std::uint64_t last) {
  SQLite::Statement rows(
      database_, "SELECT end FROM results WHERE job = ? AND sequence BETWEEN ? AND ? ORDER BY sequence");
  rows.bind(1, job);
  rows.bind(2, static_cast<std::int64_t>(first));
  rows.bind(3, static_cast<std::int64_t>(last));
  std::vector<std::uint64_t> ends;
  while (rows.executeStep()) ends.push_back(static_cast<std::uint64_t>(rows.getColumn(0).getInt64()));
  return ends;
}

std::vector<CoveredUnits> JournalRows::units(const std::string& job, std::uint64_t after,
                                             std::uint32_t most) {
  SQLite::Statement rows(
      database_, "SELECT unit, ranges FROM results WHERE job = ? AND sequence > ? ORDER BY sequence LIMIT ?");
  rows.bind(1, job);
  rows.bind(2, static_cast<std::int64_t>(after));
  rows.bind(3, most);
  std::vector<CoveredUnits> units;
  while (rows.executeStep()) units.push_back({rows.getColumn(0).getUInt(), rows.getColumn(1).getUInt()});
  return units;
}

std::vector<std::string> JournalRows::stats(const std::string& job, std::uint64_t after, std::uint32_t most) {
  SQLite::Statement rows(
      database_, "SELECT stats FROM results WHERE job = ? AND sequence > ? ORDER BY sequence LIMIT ?");
  rows.bind(1, job);
  rows.bind(2, static_cast<std::int64_t>(after));
  rows.bind(3, most);
  std::vector<std::string> stats;
  while (rows.executeStep()) stats.push_back(text(rows.getColumn(0)));
  return stats;
}

std::vector<SchedulerEvent> JournalRows::events(const std::string& job) {
  SQLite::Statement rows(database_,
                         "SELECT kind, unit, value, host, text FROM events WHERE job = ? ORDER BY number");
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

std::uint64_t JournalRows::meta(const char* key) {
  SQLite::Statement row(database_, "SELECT value FROM meta WHERE key = ?");
  row.bind(1, key);
  return row.executeStep() ? static_cast<std::uint64_t>(row.getColumn(0).getInt64()) : 0;
}

std::optional<std::uint64_t> JournalRows::log_bytes(const std::string& job) {
  SQLite::Statement row(database_, "SELECT bytes FROM logs WHERE job = ?");
  row.bind(1, job);
  if (!row.executeStep()) return std::nullopt;
  return static_cast<std::uint64_t>(row.getColumn(0).getInt64());
}

}  // namespace tessera::server
