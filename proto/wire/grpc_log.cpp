#include "wire/grpc_log.h"

#include <grpc/support/log.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <mutex>
#include <utility>

#include "wire/log.h"

namespace tessera::wire {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kLinesAMinute = 10;  // of one kind

/// How often lines of one kind came, within the minute that began at `begin`.
struct Kind {
  Clock::time_point begin;
  int lines = 0;
};

/// Counts a line; whether to write it, and how many were left out in the minute before.
std::pair<bool, int> admit(const gpr_log_func_args& args) {
  static std::mutex mutex;
  static std::map<std::pair<const char*, int>, Kind> kinds;  // by source file and line: as many as gRPC has
  const std::lock_guard lock{mutex};
  Kind& kind = kinds[{args.file, args.line}];
  const auto now = Clock::now();
  int left_out = 0;
  if (kind.lines == 0 || now - kind.begin >= std::chrono::minutes{1}) {
    left_out = std::max(0, kind.lines - kLinesAMinute);
    kind = {now, 0};
  }
  return {++kind.lines <= kLinesAMinute, left_out};
}

void write(gpr_log_func_args* args) {
  const auto level = args->severity == GPR_LOG_SEVERITY_ERROR ? spdlog::level::warn : spdlog::level::debug;
  if (!spdlog::should_log(level)) return;
  const auto [admitted, left_out] = admit(*args);
  if (left_out > 0) spdlog::log(level, "gRPC: {} lines like the next were left out", left_out);
  if (admitted) spdlog::log(level, "gRPC: {}", args->message);
}

}  // namespace

void log_grpc() { gpr_set_log_function(write); }

}  // namespace tessera::wire
