// The logs of all jobs and of the farm, as commits are added to them.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/status.h"
#include "store/log/entry_log.h"
#include "store/sqlite/journal_rows.h"
#include "store/sqlite/journal_tables.h"

namespace tessera::server {

/// For one writer. Calls throw SQLite::Exception.
class CommitLogs {
 public:
  CommitLogs(Disk& disk, std::filesystem::path data_dir, JournalRows rows)
      : disk_(disk), data_dir_(std::move(data_dir)), rows_(rows) {}

  /// Writes all entries of a commit to their logs.
  absl::Status append(CommitStamp stamp, const std::vector<JournalEntry>& entries,
                      const std::vector<PayloadPlace>& payloads);
  /// Files that have to be synced before the commit counts.
  std::vector<DiskFile*> files_to_sync() const;
  /// How far the logs reach with it, for the tables.
  void write_reach(JournalTables& tables) const;
  /// It counts, or it does not.
  void keep();
  void drop();

  /// A job is over: its log is not kept open.
  void close(const std::string& job) { logs_.erase(job); }
  /// A job is deleted.
  void remove(const std::string& job);

 private:
  EntryLog& log(const std::string& job);

  Disk& disk_;
  const std::filesystem::path data_dir_;
  JournalRows rows_;
  absl::flat_hash_map<std::string, std::unique_ptr<EntryLog>> logs_;
  absl::flat_hash_map<std::string, EntryLog*> touched_logs_;  // logs with entries of the commit under way
};

}  // namespace tessera::server
