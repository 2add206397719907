// The phases of a job's algorithm, made in this process instead of by a farm.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "support/picture/scene_file.h"

namespace tessera::test {

/// How the units of a phase are made: none of it may change the result.
struct PhaseMaking {
  int threads = 0;                // 0: one a core
  bool from_the_last = false;     // parts in the opposite order
  std::uint32_t merge_width = 0;  // 0: the phase's own
};

struct MadePhases {
  std::vector<std::string> blobs;                    // one a phase
  std::shared_ptr<const render::Prepared> prepared;  // made by all of them; null where the algorithm has none
  double cpu_seconds = 0;                            // CPU time that all parts took
};

/// Failures are those of the running test. `file` must outlive the result.
MadePhases make_phases(const LoadedFile& file, const PhaseMaking& how = {});

/// Makes the phases on one thread and returns them. Fails where other threads, orders or merges give other
/// blobs, or where a part of a square film of `side` pixels, from 16 on, has other pixels than the whole.
MadePhases expect_one_result(const LoadedFile& file, std::uint32_t side);

}  // namespace tessera::test
