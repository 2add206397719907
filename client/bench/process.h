// Another process, and what it costs from its start to its end.
#pragma once

#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"

struct rusage;

namespace tessera::client {

/// User and system time.
double cpu_seconds(const rusage& usage);

struct ProcessCost {
  double cpu_seconds = 0;  // user and system, of the process and all that it waited for
  double wall_seconds = 0;
};

/// Runs a program, found as a shell finds it, to its end; what it prints goes nowhere. Internal when it
/// cannot be run or fails, with the last line that it printed; Cancelled, and the process is killed, when
/// `stop` is requested.
absl::StatusOr<ProcessCost> run_process(const std::vector<std::string>& words, std::stop_token stop);

/// A command line of a shell, with {NAME} replaced by values, which are quoted. InvalidArgument for a {NAME}
/// that is not among them.
absl::StatusOr<std::string> fill_in(const std::string& command,
                                    const std::vector<std::pair<std::string, std::string>>& values);

}  // namespace tessera::client
