// Logs of journal entries: one of each job beside its results, one of the whole farm. Together they hold all
// that the database does, so that either can be made from the other [docs/decisions/0002-journal-format.md].
//
//   frame    u32 magic, u32 bytes of the entry, u64 commit, u32 epoch, u32 entries of that commit in all
//   logs, u32 which
//            of them this is, u32 zero, u64 checksum of all else and of the frame's place; the entry
//            (entry_bytes.h)
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "store/disk.h"
#include "store/log/entry_bytes.h"

namespace tessera::server {

/// The commit that a frame belongs to.
struct CommitStamp {
  std::uint64_t commit = 0;  // number of the commit, from 1 on, over all starts of the coordinator
  std::uint32_t epoch = 0;   // the start that it was made in
  /// Number of entries in the commit; 0: written anew from the tables, which had each of them.
  std::uint32_t entries = 0;
  std::uint32_t index = 0;  // place of this entry among them
};

/// For one writer.
class EntryLog {
 public:
  /// `bytes`: so much of the file is of commits that are known; what lies behind is overwritten.
  EntryLog(Disk& disk, std::filesystem::path path, std::uint64_t bytes)
      : disk_(disk), path_(std::move(path)), kept_(bytes), appended_(bytes) {}

  /// Opens the file, if it is not, or makes it.
  absl::Status open();
  /// Puts the entry behind all that came before.
  void append(const CommitStamp& stamp, const JournalEntry& entry, const PayloadPlace& payload);
  /// Hands what was appended to the file, so that a sync makes it durable.
  absl::Status flush();
  /// File that has to be synced before what was appended may be kept; null when nothing has.
  DiskFile* file_to_sync() const { return file_.get(); }
  /// Keeps what was appended.
  void keep() { kept_ = appended_; }
  /// Drops what was appended since the last `keep`.
  void drop();
  /// All, with what was appended.
  std::uint64_t appended_bytes() const { return appended_; }

 private:
  Disk& disk_;
  const std::filesystem::path path_;
  std::unique_ptr<DiskFile> file_;
  std::string buffer_;
  std::uint64_t kept_, appended_;  // the latter with what is in the buffer
};

/// Content of a log from some place on.
struct LogFrame {
  CommitStamp stamp;
  LoggedEntry logged;
  std::uint64_t begin = 0, end = 0;  // bytes of the file
};

/// Calls `visit` with each frame from `from` on, up to the first that is damaged or cut; gives where that
/// begins. False from `visit` ends it before the frame. Errors of the disk only.
absl::StatusOr<std::uint64_t> read_log(Disk& disk, const std::filesystem::path& path, std::uint64_t from,
                                       const std::function<bool(LogFrame)>& visit);

}  // namespace tessera::server
