// Files of a scene that include one another.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace tessera::client {

/// Bounds what includes may come to: a file that includes the next one twice, and so on, doubles with every
/// level.
class IncludeStack {
 public:
  static constexpr std::size_t kMostFiles = 100'000;
  static constexpr std::uint64_t kMostRereadBytes = std::uint64_t{1} << 30;

  /// `deepest`: files within one another, the scene's own among them.
  explicit IncludeStack(std::size_t deepest) : deepest_(deepest) {}

  /// Opens a file, for leave() to close. Returns what is wrong where it may not be read now: then it is not
  /// open.
  std::string enter(const std::filesystem::path& path);
  /// Counts the bytes of the file that was entered last. Returns what is wrong where they are too many.
  std::string count_bytes(std::uint64_t bytes);
  void leave() { open_.pop_back(); }

 private:
  const std::size_t deepest_;
  std::vector<std::string> open_;  // canonical paths
  std::set<std::string> read_;
  std::size_t files_ = 0;
  std::uint64_t bytes_again_ = 0;
};

}  // namespace tessera::client
