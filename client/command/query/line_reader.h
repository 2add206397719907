// Lines of a file or a pipe, as they come.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "command/query/query_text.h"

namespace tessera::client {

class LineReader {
 public:
  /// "-" is standard input. NotFound with the path.
  static absl::StatusOr<LineReader> open(const std::string& path);
  LineReader(LineReader&& other) noexcept;
  LineReader& operator=(LineReader&&) = delete;
  ~LineReader();

  const std::string& name() const { return name_; }

  enum class Got {
    kLine,
    kTooLong,  // a line of more than kLongestQueryLine bytes, left out
    kEnd       // of the file; or failed()
  };
  /// Waits for it where it has to. The line is valid until the next call.
  Got next(std::string_view& line);
  /// Whether the file cannot be read on.
  bool failed() const { return failed_; }
  /// Whether next() would return at once.
  bool ready();

 private:
  LineReader(int file, std::string name) : file_(file), name_(std::move(name)) {}
  bool fill();

  int file_;
  std::string name_;
  std::string buffer_;
  std::size_t unread_begin_ = 0;
  bool ended_ = false, failed_ = false;
};

}  // namespace tessera::client
