// Files of a test's directory.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "support/process/temp_dir.h"

namespace tessera::client {

inline std::string operator/(const support::TempDir& directory, const std::string& name) {
  return (directory.path() / name).string();
}

inline std::size_t file_count(const support::TempDir& directory) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(directory.path()),
                                                std::filesystem::directory_iterator()));
}

inline std::string read_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// A new file, for some file systems flush a truncated one to disk when it is closed.
inline void write_bytes(const std::string& path, const std::string& bytes) {
  std::filesystem::remove(path);
  std::ofstream(path, std::ios::binary) << bytes;
}

}  // namespace tessera::client
