// Opening the journal: what was committed is there, or is said to be lost.
#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "store/log/log_recovery.h"
#include "store/sqlite/checked_pages.h"
#include "store/sqlite/sqlite_journal.h"
#include "store/sqlite/sqlite_status.h"
#include "telemetry/log.h"

namespace tessera::server {
namespace {

constexpr char kDamaged[] = ".damaged";

/// Damaged tables make room for new ones, if there is something to make those of. False when there is not.
absl::StatusOr<bool> set_tables_aside(const std::filesystem::path& data_dir, const JournalOptions& options,
                                      Disk& disk) {
  const auto log = disk.open(log_path(data_dir, ""), /*create=*/false);
  if (!log.ok() && !absl::IsNotFound(log.status())) return log.status();
  if (!log.ok() && !options.accept_loss) return false;
  for (const char* suffix : {"", "-wal"}) {
    const std::filesystem::path path = data_dir / absl::StrCat(kTables, suffix);
    if (absl::Status status = disk.move(path, path.string() + kDamaged); !status.ok()) return status;
  }
  absl::Status status = disk.sync_directory(data_dir);
  if (!status.ok()) return status;
  return true;
}

}  // namespace

SqliteJournal::SqliteJournal(const std::filesystem::path& data_dir, Disk& disk)
    : data_dir_(data_dir),
      disk_(disk),
      database_(data_dir.empty() ? ":memory:" : (data_dir / kTables).string(),
                SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE, /*busyTimeoutMs=*/0, disk.sqlite_vfs()) {
  // Files that SQLite makes beside it get the same rights. On a simulated disk there is no such file.
  std::error_code none;
  if (!data_dir.empty()) {
    std::filesystem::permissions(
        data_dir / kTables, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write, none);
  }
  // The data directory is this process's alone (data_dir.h), so nobody else needs to see the index of the
  // log.
  database_.exec("PRAGMA locking_mode = EXCLUSIVE");
  // Its log is copied into the database by checkpoint() alone.
  sqlite3_wal_hook(database_.getHandle(), &SqliteJournal::note_wal_pages, this);
  sqlite3_db_config(database_.getHandle(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  database_.execAndGet("PRAGMA schema_version");  // reads the first page: damage there is to be called so
  if (!data_dir.empty() && disk.sqlite_vfs() == checked_pages_vfs() &&
      make_room_for_checksums(database_.getHandle()) != SQLITE_OK) {
    throw SQLite::Exception(database_.getHandle());
  }
  database_.exec("PRAGMA journal_mode = WAL");
  database_.exec("PRAGMA synchronous = FULL");
}

SqliteJournal::~SqliteJournal() {
  if (health_.ok() && manifest_ && logs_) static_cast<void>(checkpoint());
}

absl::Status SqliteJournal::begin(std::optional<Manifest> manifest, bool accept_loss) {
  if (absl::Status status = JournalTables::prepare(database_); !status.ok()) {
    return absl::Status(status.code(), absl::StrCat(data_dir_.string(), ": ", std::string(status.message())));
  }
  tables_.emplace(database_);
  if (!manifest) {
    epoch_ = JournalTables::begin_epoch(database_, 0);
    return absl::OkStatus();
  }
  const std::optional<ManifestCounts> expected = manifest->found();
  const bool new_tables = rows_.meta("epoch") == 0;
  if (expected && !new_tables && (expected->damaged != 0 || rows_.meta("commit") < expected->checkpoint)) {
    return absl::DataLossError(
        absl::StrCat((data_dir_ / kTables).string(), " lacks a part of its log (WAL)"));
  }
  SQLite::Transaction transaction(database_);
  LogRecovery recovery(disk_, data_dir_, database_, *tables_, new_tables, expected);
  const absl::StatusOr<LogRecovery::Report> report = recovery.complete_tables();
  if (!report.ok()) return report.status();
  for (const std::string& what : report->healed) spdlog::error("{}: {}", data_dir_.string(), what);
  for (const std::string& what : report->lost) spdlog::error("{}: lost: {}", data_dir_.string(), what);
  if (!report->lost.empty() && !accept_loss) {
    return absl::FailedPreconditionError(absl::StrCat(
        data_dir_.string(), ": something that was acknowledged is lost: ", absl::StrJoin(report->lost, "; "),
        ". Put back what is missing, or start once with --accept-loss to go on with what there is"));
  }
  counts_ = report->counts;
  counts_.checkpoint = expected ? expected->checkpoint : 0;
  const std::uint64_t past = std::max(counts_.epoch, expected ? expected->epoch : 0);
  counts_.epoch = epoch_ = JournalTables::begin_epoch(database_, past);
  transaction.commit();
  if (absl::Status status = recovery.complete_logs(); !status.ok()) return status;
  manifest_ = std::move(manifest);
  logs_.emplace(disk_, data_dir_, rows_);
  if (report->changed) return checkpoint();
  return manifest_->write(counts_);
}

absl::StatusOr<std::unique_ptr<Journal>> open_journal(const std::filesystem::path& data_dir,
                                                      const JournalOptions& options, Disk& disk) {
  std::unique_ptr<SqliteJournal> journal;
  const auto open = [&](std::optional<Manifest> manifest) {
    return guarded("opening", [&] {
      journal = std::make_unique<SqliteJournal>(data_dir, disk);
      return journal->begin(std::move(manifest), options.accept_loss);
    });
  };
  const auto open_on_disk = [&]() -> absl::Status {
    absl::StatusOr<Manifest> manifest = Manifest::open(disk, data_dir / "manifest");
    return manifest.ok() ? open(*std::move(manifest)) : manifest.status();
  };
  absl::Status status = data_dir.empty() ? open(std::nullopt) : open_on_disk();
  if (absl::IsDataLoss(status) && !data_dir.empty()) {
    const std::string damage(status.message());
    journal.reset();
    const absl::StatusOr<bool> aside = set_tables_aside(data_dir, options, disk);
    if (!aside.ok()) return aside.status();
    if (!*aside) return absl::DataLossError(absl::StrCat(damage, "; there are no logs to make it anew from"));
    spdlog::error("{}: it is made anew from the logs beside the results, and kept as {}{}", damage, kTables,
                  kDamaged);
    status = open_on_disk();
  }
  if (!status.ok()) return status;
  return journal;
}

}  // namespace tessera::server
