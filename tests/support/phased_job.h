// Jobs in phases, for tests of the farm that render nothing.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tessera/v1/job.pb.h"
#include "wire/algorithm.h"
#include "wire/job_check.h"

namespace tessera::test {

inline constexpr const char* kIntegratorWithPhases = "test-phases";
inline constexpr std::array kTestPhases{wire::PhaseTraits{.name = "first"},
                                        wire::PhaseTraits{.name = "second"}};

/// Makes the integrator of that name known to this program.
inline const bool phases_are_known = [] {
  wire::add_algorithm({.name = kIntegratorWithPhases, .phases = kTestPhases});
  return true;
}();

/// One number of parts a phase; blobs are merged three at a time.
inline void add_test_phases(v1::JobSpec& spec, const std::vector<std::uint32_t>& parts) {
  spec.mutable_content()->mutable_algorithms()->set_integrator(kIntegratorWithPhases);
  for (const std::uint32_t count : parts) {
    v1::Phase& phase = *spec.mutable_cut()->add_phases();
    phase.set_name(kTestPhases[static_cast<std::size_t>(spec.cut().phases_size()) - 1].name);
    phase.set_parts(count);
    phase.set_merge_width(3);
  }
}

}  // namespace tessera::test
