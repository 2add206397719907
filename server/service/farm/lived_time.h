// Time that a coordinator lived through, which no step of the clock on the wall changes.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "absl/container/flat_hash_map.h"
#include "absl/status/status.h"

namespace tessera::server {

/// How long ago jobs ended, by a clock that runs while a coordinator does: time between two coordinators
/// counts for nothing, and neither do steps of the machine's clock, or nights in which it sleeps. Not
/// thread-safe.
class LivedTime {
 public:
  using Time = std::chrono::milliseconds;

  /// Goes on where the file's writer was. Where there is none, or it cannot be read, everything ends now:
  /// jobs are kept for longer than they had to be, never for less.
  explicit LivedTime(std::filesystem::path file = {});

  /// Takes in what two clocks say: one that only ever runs, and the one on the wall. Returns by how much the
  /// wall's was set since the last call, forwards or back.
  Time advance(Time steady, Time wall);

  /// How long ago the job ended. The first call is the moment of its end.
  Time since_end_of(const std::string& job);
  /// The job goes on, or is deleted.
  void forget(const std::string& job) { ends_.erase(job); }

  /// Text that is to be in the file. Empty where there is none.
  std::string to_text() const;
  /// Replaces the file; to be called from wherever a disk may take its time.
  static absl::Status save(const std::filesystem::path& file, const std::string& text);
  const std::filesystem::path& file() const { return file_; }

 private:
  absl::Status read();

  const std::filesystem::path file_;
  Time lived_{0};
  std::optional<Time> steady_, wall_;  // times of the last advance()
  absl::flat_hash_map<std::string, Time> ends_;
};

}  // namespace tessera::server
