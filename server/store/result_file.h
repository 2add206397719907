// The payloads of one job's results, one after another in order of their sequence numbers.
#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "store/disk.h"
#include "store/file.h"

namespace tessera::server {

/// One writer, any number of readers. The file is open only while the job is, so that old jobs cost no
/// descriptor.
class ResultFile {
 public:
  /// `ends[i]` is where result i + 1 ends, as journaled. What lies beyond the last was never acknowledged and
  /// is overwritten. An empty path: in memory.
  ResultFile(Disk& disk, std::filesystem::path path, std::vector<std::uint64_t> ends);

  /// Opens the file of a job that is over: `count` results, of which the last ends at `end`. Where they end
  /// is told when they are read.
  ResultFile(Disk& disk, std::filesystem::path path, std::uint64_t count, std::uint64_t end);

  /// How many results, from the first on, lie within the file, when all their ends are remembered; fewer than
  /// were journaled when something cut it.
  std::uint64_t whole_results() const;

  /// Whether the file is at least so long.
  bool holds(std::uint64_t bytes) const;

  /// Writes behind all that was written before; the bytes count as a result once `keep` was called. Gives
  /// where they end.
  absl::StatusOr<std::uint64_t> append(std::string_view payload);
  /// File that has to be synced before what was appended may be kept; null when nothing has. For the writer.
  DiskFile* file_to_sync() const { return file_.get(); }
  void keep(std::uint64_t end);
  /// No more results will come, unless the job is opened again.
  void close();
  /// Forgets where results end: the memory that a job takes must not outlive it.
  void forget_ends();
  /// Remembers, instead of all else, where results end that come behind the first `before` ones, which end at
  /// `begin`.
  void remember_ends(std::uint64_t before, std::uint64_t begin, std::vector<std::uint64_t> ends);

  struct Extent {
    std::uint64_t begin = 0, end = 0;
  };
  /// Place of result `sequence`, from 1 on; nothing when it is not remembered. OutOfRange when there is no
  /// such result.
  absl::StatusOr<std::optional<Extent>> extent(std::uint64_t sequence) const;
  absl::StatusOr<std::string> read(const Extent& extent) const;

 private:
  bool in_memory() const { return path_.empty(); }
  std::uint64_t size() const;

  Disk& disk_;
  const std::filesystem::path path_;
  mutable std::mutex mutex_;
  std::optional<File> memory_;  // instead of a file on the disk
  std::unique_ptr<DiskFile> file_;
  std::uint64_t count_;
  std::uint64_t before_ = 0;         // number of results before the remembered ones
  std::uint64_t begin_ = 0;          // offset at which these end
  std::vector<std::uint64_t> ends_;  // ends of the remembered results
  std::uint64_t kept_;               // offset at which the last result ends
  std::uint64_t appended_;
};

}  // namespace tessera::server
