// The journal in SQLite, with files beside it [docs/decisions/0002-journal-format.md].
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>
#include <sqlite3.h>

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "store/data_dir.h"
#include "store/journal.h"
#include "store/log/commit_logs.h"
#include "store/log/manifest.h"
#include "store/result_file.h"
#include "store/sqlite/journal_rows.h"
#include "store/sqlite/journal_tables.h"

namespace tessera::server {

/// The name of the database within the data directory.
inline constexpr char kTables[] = "journal.sqlite";

/// The coordinator's one writer; readers only touch result files.
class SqliteJournal final : public Journal {
 public:
  /// Throws SQLite::Exception.
  SqliteJournal(const std::filesystem::path& data_dir, Disk& disk);
  ~SqliteJournal() override;

  /// Begins a new epoch, with all that was committed, or says what is lost. Throws SQLite::Exception.
  absl::Status begin(std::optional<Manifest> manifest, bool accept_loss);

  std::uint64_t epoch() const override { return epoch_; }
  absl::Status recover(const std::function<absl::Status(JobRecord)>& visit) override;
  absl::StatusOr<JobRecord> read_job(const std::string& job) override;
  absl::StatusOr<std::vector<SchedulerEvent>> farm_events() override;
  absl::Status commit(const std::vector<JournalEntry>& entries) override;
  absl::StatusOr<std::string> read_result(const std::string& job, std::uint64_t sequence) override;
  absl::StatusOr<std::vector<CoveredUnits>> read_units(const std::string& job, std::uint64_t after,
                                                       std::uint32_t most) override;
  absl::StatusOr<std::vector<std::string>> read_stats(const std::string& job, std::uint64_t after,
                                                      std::uint32_t most) override;

 private:
  static int note_wal_pages(void* self, sqlite3*, const char*, int pages) {
    static_cast<SqliteJournal*>(self)->wal_pages_ = pages;
    return SQLITE_OK;
  }

  std::shared_ptr<ResultFile> results_of(const std::string& job);

  // With database_mutex_ held, as what follows.
  /// Calls `function`. A page that cannot be read is noted in the manifest: the next start makes the tables
  /// anew.
  template <typename Function>
  absl::Status read_tables(const char* what, Function function);
  absl::Status recover_job(JobRecord& record);
  absl::StatusOr<ResultFile::Extent> find_result(const std::string& job, std::uint64_t sequence,
                                                 ResultFile& file);
  absl::StatusOr<bool> write_payloads(const std::vector<JournalEntry>& entries,
                                      std::vector<PayloadPlace>& places, std::vector<DiskFile*>& files);
  absl::Status write_files(const std::vector<JournalEntry>& entries, std::vector<PayloadPlace>& places);
  void write_rows(const std::vector<JournalEntry>& entries, const std::vector<PayloadPlace>& places);
  void put_in_effect(const JournalEntry& entry, std::uint64_t end);
  /// Copies SQLite's log into its database.
  absl::Status checkpoint();

  std::filesystem::path path_of(const std::string& job) const {
    return data_dir_.empty() ? std::filesystem::path() : result_path(data_dir_, job);
  }

  std::filesystem::path data_dir_;
  Disk& disk_;
  std::uint64_t epoch_ = 0;

  std::mutex database_mutex_;
  SQLite::Database database_;
  JournalRows rows_{database_};
  std::optional<JournalTables> tables_;
  // On a disk:
  std::optional<CommitLogs> logs_;
  std::optional<Manifest> manifest_;
  ManifestCounts counts_;
  int wal_pages_ = 0;
  absl::Status health_;  // the first error of a commit

  std::mutex results_mutex_;
  absl::flat_hash_map<std::string, std::shared_ptr<ResultFile>> results_;
};

}  // namespace tessera::server
