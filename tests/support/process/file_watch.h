// Waiting for another program to write a file.
#pragma once

#include <chrono>
#include <filesystem>

namespace tessera::support {

/// Hears of every write to a file that exists, or to any file in a directory, from its construction on.
class FileWatch {
 public:
  /// Throws std::system_error when the path cannot be watched.
  explicit FileWatch(const std::filesystem::path& path);
  ~FileWatch();
  FileWatch(const FileWatch&) = delete;
  FileWatch& operator=(const FileWatch&) = delete;

  /// Returns at the next write, and forgets all others until then; false when none comes within `patience`.
  bool wait(std::chrono::milliseconds patience);

 private:
  int descriptor_ = -1;
};

}  // namespace tessera::support
