// The journal's tables in SQLite: their schema, and the statements that write them.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <cstdint>

#include "absl/status/statusor.h"
#include "store/journal.h"

namespace tessera::server {

class JournalTables {
 public:
  /// Makes the tables, or brings those of older formats up to date. FailedPrecondition when the format is not
  /// known. Throws SQLite::Exception.
  static absl::Status prepare(SQLite::Database& database);
  /// Counts this opening. Its number, from 1 on, and larger than `past`. Throws SQLite::Exception.
  static std::uint64_t begin_epoch(SQLite::Database& database, std::uint64_t past);

  /// `database` has the tables. Throws SQLite::Exception.
  explicit JournalTables(SQLite::Database& database);

  /// Within a transaction of the caller's. `end`: where the payload of a result ends within the job's result
  /// file. Throws SQLite::Exception.
  void write(const JournalEntry& entry, std::uint64_t end);
  /// So much of the job's log, or of the farm's, is in the tables.
  void write_log(const std::string& job, std::uint64_t bytes);
  /// The log is not as the tables know it.
  void forget_log(const std::string& job);
  /// The tables have all commits up to this one.
  void write_commit(std::uint64_t commit);

 private:
  void write_row(const JobAdded& entry, std::uint64_t end);
  void write_row(const JobBound& entry, std::uint64_t end);
  void write_row(const JobEnded& entry, std::uint64_t end);
  void write_row(const UnitDone& entry, std::uint64_t end);
  void write_row(const JobStats& entry, std::uint64_t end);
  void write_row(const SchedulerEvent& entry, std::uint64_t end);
  void write_row(const JobReopened& entry, std::uint64_t end);
  void write_row(const JobFetched& entry, std::uint64_t end);
  void write_row(const JobPruned& entry, std::uint64_t end);

  SQLite::Statement add_, bind_, end_, done_, stats_, event_, fetched_, prune_job_, prune_results_,
      prune_events_, log_, forget_log_, commit_;
};

}  // namespace tessera::server
