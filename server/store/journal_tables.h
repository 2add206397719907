// The journal's tables in SQLite: their schema, and the statements that write them.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <cstdint>

#include "absl/status/statusor.h"
#include "store/journal.h"

namespace tessera::server {

class JournalTables {
 public:
  /// Makes the tables, or brings those of older formats up to date, and counts this opening. Its number, from 1 on;
  /// FailedPrecondition when the format is not known. Throws SQLite::Exception.
  static absl::StatusOr<std::uint64_t> begin_epoch(SQLite::Database& database);

  /// `database` has the tables. Throws SQLite::Exception.
  explicit JournalTables(SQLite::Database& database);

  /// Within a transaction of the caller's. `end`: where the payload of a result ends within the job's result file.
  /// Throws SQLite::Exception.
  void write(const JournalEntry& entry, std::uint64_t end);

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

  SQLite::Statement add_, bind_, end_, done_, stats_, event_, fetched_, prune_job_, prune_results_, prune_events_;
};

}  // namespace tessera::server
