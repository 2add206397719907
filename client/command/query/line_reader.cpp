#include "command/query/line_reader.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "absl/strings/str_cat.h"

namespace tessera::client {

absl::StatusOr<LineReader> LineReader::open(const std::string& path) {
  if (path == "-") return LineReader(STDIN_FILENO, "standard input");
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return absl::NotFoundError(absl::StrCat("cannot read ", path));
  return LineReader(file, path);
}

LineReader::LineReader(LineReader&& other) noexcept
    : file_(std::exchange(other.file_, -1)), name_(std::move(other.name_)) {}

LineReader::~LineReader() {
  if (file_ > STDIN_FILENO) ::close(file_);
}

bool LineReader::fill() {
  if (ended_) return false;
  buffer_.erase(0, std::exchange(unread_begin_, 0));
  constexpr std::size_t kPiece = 1 << 18;
  const std::size_t size = buffer_.size();
  buffer_.resize(size + kPiece);
  ssize_t got;
  do {
    got = ::read(file_, buffer_.data() + size, kPiece);
  } while (got < 0 && errno == EINTR);
  buffer_.resize(size + static_cast<std::size_t>(got > 0 ? got : 0));
  ended_ = got <= 0, failed_ = got < 0;
  return !ended_;
}

bool LineReader::ready() {
  if (ended_ || buffer_.find('\n', unread_begin_) != buffer_.npos) return true;
  pollfd waiting{file_, POLLIN, 0};
  return ::poll(&waiting, 1, 0) > 0;
}

LineReader::Got LineReader::next(std::string_view& line) {
  bool too_long = false;
  std::size_t searched = unread_begin_;
  for (;;) {
    const std::size_t end = buffer_.find('\n', searched);
    if (end != buffer_.npos) {
      line = std::string_view(buffer_).substr(unread_begin_, end - unread_begin_);
      unread_begin_ = end + 1;
      return too_long || line.size() > kLongestQueryLine ? Got::kTooLong : Got::kLine;
    }
    if (buffer_.size() - unread_begin_ > kLongestQueryLine) {
      too_long = true;
      unread_begin_ = buffer_.size();
    }
    if (!fill()) break;
    searched = unread_begin_;
  }
  line = std::string_view(buffer_).substr(unread_begin_);
  unread_begin_ = buffer_.size();
  if (too_long) return Got::kTooLong;
  return line.empty() ? Got::kEnd : Got::kLine;
}

}  // namespace tessera::client
