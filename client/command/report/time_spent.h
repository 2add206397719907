// Where the CPU time of a job went.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tessera/v1/job.pb.h"

namespace tessera::client {

struct TimePart {
  std::string name;
  double seconds = 0;
};

struct TimeSpent {
  double seconds = 0;  // all of `stages`
  /// Stages in the order of the work; "other" is what no stage of rendering accounts for.
  std::vector<TimePart> stages;
  std::vector<TimePart> shading;  // shares of the stage "shading", which they add up to; empty where unknown
  std::vector<TimePart> materials;  // shares of the part "materials" of shading, the largest first
};

/// CPU time of this process, where it did everything: coordinator and worker too.
struct ProcessTime {
  double start_seconds = 0;  // before the command began: loading libraries and modules
  double import_seconds = 0;
  double pilot_seconds = 0;  // time to choose the integrator
  double total_seconds = 0;
};

/// Sums up what the workers told. With `process`, "start", "import", "pilot" (where there was one) and
/// "coordination" (messages, the coordinator's work and putting the image together: what nothing else
/// accounts for) are known too.
TimeSpent time_spent(const v1::UnitStats& stats, const std::optional<ProcessTime>& process = std::nullopt);

/// "12.3 CPU s: import 4 %, build 10 %, ... shading 31 % (surfaces 9 %, materials 14 %, ...)", and the
/// largest materials; one line or two, without the last end of line. Empty when nothing was measured.
std::string to_text(const TimeSpent& spent);

}  // namespace tessera::client
