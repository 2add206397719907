#include "net/grpc_log.h"

#include <grpc/support/log.h>
#include <cstdlib>

#include <map>
#include <mutex>
#include <utility>

#include "telemetry/line_limit.h"
#include "telemetry/log.h"

namespace tessera::net {
namespace {

/// The limit of a source file and line: there are as many kinds as gRPC has.
telemetry::LineLimit& limit_of(const gpr_log_func_args& args) {
  // Never destroyed: gRPC's threads may log while the program ends.
  static auto& mutex = *new std::mutex;
  static auto& limits = *new std::map<std::pair<const char*, int>, telemetry::LineLimit>;
  const std::lock_guard lock{mutex};
  return limits[{args.file, args.line}];
}

void write(gpr_log_func_args* args) {
  const auto level = args->severity == GPR_LOG_SEVERITY_ERROR ? spdlog::level::warn : spdlog::level::debug;
  if (!spdlog::should_log(level)) return;
  const auto [admitted, left_out] = limit_of(*args).count();
  if (left_out > 0) spdlog::log(level, "gRPC: {} lines like the next were left out", left_out);
  if (admitted) spdlog::log(level, "gRPC: {}", args->message);
}

}  // namespace

void log_grpc() { gpr_set_log_function(write); }

void mute_grpc() {
  if (std::getenv("GRPC_VERBOSITY") == nullptr) gpr_set_log_function([](gpr_log_func_args*) {});
}

}  // namespace tessera::net
