// The last lines of a program's log, for who looks on.
#pragma once

#include <spdlog/sinks/base_sink.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace tessera::telemetry {

struct LogLine {
  std::uint64_t number = 0;  // counted from 1
  std::int64_t unix_ms = 0;
  std::string level;        // "info"
  bool is_warning = false;  // a warning or worse
  std::string message;
  std::string job, worker, user;  // fields of the line; empty where it has none
};

/// Keeps the last kMost lines that the log's level lets through.
class RecentLines final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  static constexpr std::size_t kMost = 1000;

  /// Returns the lines after number `after`, oldest first.
  std::vector<LogLine> after(std::uint64_t after);

  /// The last lines about this job, and warnings and errors about none, oldest first, as many as have
  /// `most_bytes` together: "2026-01-31T12:00:00.000Z [error] message". Control characters are escaped.
  std::vector<std::string> last_about(std::string_view job, std::size_t most_bytes);

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override;
  void flush_() override {}

 private:
  std::deque<LogLine> lines_;
  std::uint64_t count_ = 0;
};

/// From here on, the process's lines go there too. After set_up_log(), and before there are other threads.
std::shared_ptr<RecentLines> keep_recent_lines();

}  // namespace tessera::telemetry
