// News of a job, for people who follow it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tessera/v1/job.pb.h"

namespace tessera::client {

/// Names the unit, or the run of units, that was not rendered.
std::string name_of(const v1::FailedUnit& failed);

/// Compares each status with the one before.
class JobNews {
 public:
  static constexpr int kMostFailures = 3;  // told of one status; the rest is counted

  /// Returns the news: paused or resumed, who is left out, and units that failed, the oldest first. May be
  /// shown on a terminal.
  std::vector<std::string> lines(const v1::JobStatus& status);

 private:
  bool paused_ = false;
  std::string left_out_;
  std::uint64_t failures_ = 0;
};

}  // namespace tessera::client
