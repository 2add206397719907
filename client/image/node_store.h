// Where tile results wait for the sibling that they merge with.
#pragma once

#include <cstddef>
#include <cstdio>
#include <memory>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "wire/tile_result.h"

namespace tessera::client {

/// Holds results in memory up to a bound and puts what comes beyond it into an unnamed temporary file. In the
/// order in which a coordinator sends them, results rarely wait for long and no file is ever made.
class NodeStore {
 public:
  explicit NodeStore(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  /// One stored result; goes back into take() of the same store, once.
  struct Entry {
    std::optional<wire::TileResult> result;  // empty: in the file
    long offset = 0;
    std::size_t size = 0;
  };

  /// Internal when the temporary file cannot be written.
  absl::StatusOr<Entry> put(wire::TileResult result);
  /// Internal when the temporary file cannot be read back.
  absl::StatusOr<wire::TileResult> take(Entry entry);

  std::size_t bytes_in_file() const { return static_cast<std::size_t>(file_end_); }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  absl::Status open_file();

  std::size_t max_bytes_;
  std::size_t bytes_ = 0;
  std::unique_ptr<std::FILE, Close> file_;
  long file_end_ = 0;
};

}  // namespace tessera::client
