// A job of two phases, for farms whose programs know the algorithm `histogram`.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <string>

#include "integration/farm_under_test.h"

namespace tessera::integration {

// 5 parts and 6 merges, 60 parts and 20 merges, and 400 tiles.
inline Arguments job_of(const std::string& spp) {
  return {"scenes/cornell-box/scene.pbrt",
          "--integrator",
          "histogram",
          "--resolution",
          "160x160",
          "--spp",
          spp,
          "--tile",
          "8",
          "--quiet"};
}
inline const Arguments kJob = job_of("8");
inline constexpr std::uint32_t kFirstPhaseUnits = 5 + 6, kPhaseUnits = kFirstPhaseUnits + 60 + 20;

class Phases : public testing::Test {
 protected:
  static void SetUpTestSuite() { use_programs_of(TESSERA_WITH_HISTOGRAM); }
};

}  // namespace tessera::integration
