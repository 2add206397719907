// A command of the user's that is run when a job is over.
#pragma once

#include <string>

#include "options/program.h"
#include "tessera/v1/job.pb.h"

namespace tessera::client {

struct OnDone {
  std::string command;  // run by /bin/sh; empty: none

  /// Runs the command, however the job ended, and waits for it. It has TESSERA_JOB (the id), TESSERA_NAME,
  /// TESSERA_STATE ("done", "failed", "cancelled", "incomplete"), TESSERA_ERROR and TESSERA_OUTPUT (the
  /// image, as it was named; empty where none was asked for or written) in its environment: nothing of a job
  /// becomes part of what the shell reads. Returns `exit_code`; where that is 0 and the command failed, says
  /// so and returns kIncomplete.
  int run(const v1::JobStatus& status, const std::string& output, int exit_code) const;
};

void define_on_done_option(options::Command& command, std::string& value);

}  // namespace tessera::client
