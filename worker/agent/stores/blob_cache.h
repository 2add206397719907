// Blobs on this machine's disk, named by content. Several workers may share one directory.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "agent/stores/mapped_file.h"
#include "base/clock.h"
#include "render/scene/load_scene.h"

namespace tessera::agent {

/// Whole blobs lie at `dir/ab/abcd...`, parts of a download at `dir/partial/abcd...`. A blob appears under
/// its name only when its digest has been verified. Thread-safe, and safe between processes.
class BlobCache {
 public:
  /// Creates `dir` where needed. Blobs used longest ago are removed while there are more than `cap_bytes`.
  static absl::StatusOr<std::unique_ptr<BlobCache>> open(base::Clock& clock, std::filesystem::path dir,
                                                         std::uint64_t cap_bytes);

  /// The blob, mapped into memory, when the cache has it. A file whose bytes have another digest by now is
  /// removed, and is no blob.
  absl::StatusOr<std::optional<render::BlobBytes>> find(const std::string& digest);

  using Sink = std::function<absl::Status(std::string_view chunk)>;
  /// Delivers the bytes from `offset` on.
  using Fetch = std::function<absl::Status(std::uint64_t offset, const Sink& sink)>;

  /// The blob; what is missing of it is fetched first, from where an interrupted fetch ended. DataLoss when
  /// the fetched bytes do not have this digest (the part is then thrown away). While another thread or
  /// process fetches the same blob, waits for it.
  absl::StatusOr<render::BlobBytes> get(const std::string& digest, const Fetch& fetch);

  /// Removes the blob, if it is there. Whoever has it mapped keeps its bytes.
  void drop(const std::string& digest);

  /// Bytes that it held after the last blob came, parts of downloads included.
  std::uint64_t bytes() const { return bytes_; }

 private:
  BlobCache(base::Clock& clock, std::filesystem::path dir, std::uint64_t cap_bytes);

  std::filesystem::path blob_path(const std::string& digest) const;
  std::filesystem::path partial_path(const std::string& digest) const;
  void prune(const std::string& keep);
  absl::StatusOr<bool> is_intact(const OpenFile& file, const std::string& digest);
  void note_checked(const OpenFile& file, const std::string& digest);

  base::Clock& clock_;
  const std::filesystem::path dir_;
  const std::uint64_t cap_bytes_;
  std::mutex prune_mutex_;
  std::atomic<std::uint64_t> bytes_{0};
  /// When which file was last seen to have the bytes that its name says.
  struct Checked {
    std::uint64_t inode = 0;
    base::Clock::TimePoint when;
  };
  std::mutex checked_mutex_;
  std::map<std::string, Checked> checked_;
  /// The right to fetch a blob, among the threads of this process: it is waited for by the clock.
  class Turn;
  std::mutex turns_mutex_;
  base::Condition turn_ended_{clock_};
  std::set<std::string> turns_;  // digests of blobs that are fetched
};

/// $XDG_CACHE_HOME/tessera, or ~/.cache/tessera, or a directory for this user under the system's temporary
/// one.
std::filesystem::path default_cache_dir();

}  // namespace tessera::agent
