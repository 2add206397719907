// Lines of the log of which others decide how many there are.
#pragma once

#include <algorithm>
#include <chrono>
#include <mutex>

namespace tessera::telemetry {

/// At most kLinesAMinute lines of one kind are written, and how many were left out before. Thread-safe.
class LineLimit {
 public:
  static constexpr int kLinesAMinute = 10;

  struct Verdict {
    bool write = false;
    int left_out = 0;  // lines left out in the minute before this one's
  };
  Verdict count(std::chrono::steady_clock::time_point now = std::chrono::steady_clock::now()) {
    const std::lock_guard lock{mutex_};
    Verdict verdict;
    if (lines_ == 0 || now - begin_ >= std::chrono::minutes{1}) {
      verdict.left_out = std::max(0, lines_ - kLinesAMinute);
      begin_ = now;
      lines_ = 0;
    }
    verdict.write = ++lines_ <= kLinesAMinute;
    return verdict;
  }

 private:
  std::mutex mutex_;
  std::chrono::steady_clock::time_point begin_;
  int lines_ = 0;  // lines since begin_
};

}  // namespace tessera::telemetry
