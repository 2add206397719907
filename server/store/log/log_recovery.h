// Brings the journal's tables and its logs into agreement when it is opened: what the tables lack is taken
// from the logs, what the logs lack is written from the tables, and what neither has is said to be lost.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "absl/container/flat_hash_set.h"
#include "absl/status/statusor.h"
#include "store/disk.h"
#include "store/log/entry_log.h"
#include "store/log/manifest.h"
#include "store/sqlite/journal_rows.h"
#include "store/sqlite/journal_tables.h"

namespace tessera::server {

/// Used once. Calls throw SQLite::Exception besides what they return.
class LogRecovery {
 public:
  /// `new_tables`: nobody has used them yet. `expected`: what the manifest says.
  LogRecovery(Disk& disk, std::filesystem::path data_dir, SQLite::Database& database, JournalTables& tables,
              bool new_tables, const std::optional<ManifestCounts>& expected);

  struct Report {
    ManifestCounts counts;            // numbers of what there is; the epoch is the highest that was met
    std::vector<std::string> healed;  // damage that costs nothing that was acknowledged
    std::vector<std::string> lost;    // damage that does
    bool changed = false;             // there was something to do
  };
  /// Completes the tables, within a transaction of the caller's. Files stay as they are.
  absl::StatusOr<Report> complete_tables();

  /// Once that is committed: completes the logs, and deletes what is left of deleted jobs.
  absl::Status complete_logs();

 private:
  /// Entries of a log behind those that the tables know.
  struct Tail {
    std::string job;
    std::uint64_t from = 0, end = 0, size = 0;
    std::int64_t submitted_unix_ms = 0;  // set where the tables do not have the job
    CommitStamp first, last;
    std::uint64_t last_frames_begin = 0;  // offset at which the frames of `last` begin
    std::uint64_t previous_commit = 0;    // the one before `last`
    std::vector<LoggedEntry> last_entries;
  };

  absl::Status find_tails();
  absl::Status look_at(const std::string& job, bool has_row);
  absl::Status read_tail(Tail& tail);
  bool is_complete(std::uint64_t commit);
  bool has_payload(const LoggedEntry& logged);
  void drop_unfinished();
  absl::Status take_in(Tail& tail);
  bool may_be_torn() const;
  bool is_unfinished(const Tail& tail) const;
  bool is_damaged(const std::string& job) const;
  absl::Status compare(const std::vector<std::string>& ids);
  absl::StatusOr<std::uint64_t> write_anew(const std::string& job);
  std::filesystem::path path_of(const std::string& job) const;

  Disk& disk_;
  const std::filesystem::path data_dir_;
  SQLite::Database& database_;
  JournalTables& tables_;
  JournalRows rows_;
  const bool new_tables_;
  const std::optional<ManifestCounts> expected_;

  Report report_;
  std::vector<std::string> names_;  // names of the files in results/
  std::vector<Tail> tails_;
  std::vector<std::string> damaged_;     // logs with something behind their last sound frame
  std::vector<std::string> incomplete_;  // logs that are to be written anew
  absl::flat_hash_set<std::string> pruned_;
};

}  // namespace tessera::server
