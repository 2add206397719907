// A farm whose workers stop at a latch, so that a test can do something while they certainly hold units.
#pragma once

#include <gtest/gtest.h>

#include <fstream>

#include "integration/farm_under_test.h"
#include "integration/phases/latched_traits.h"

namespace tessera::integration {

/// Tests of such farms: all programs know the algorithm `latched`.
class WithLatch : public testing::Test {
 protected:
  WithLatch() { use_programs_of(TESSERA_WITH_HISTOGRAM); }
  ~WithLatch() override { use_programs_of(TESSERA_USUAL_PROGRAMS); }
};

/// 36 units of a moment each.
inline Arguments latched_job(const Arguments& integrator = {"--integrator", kLatched}) {
  return in_many_units("96", "16") + integrator;
}

/// The pixels that the farm has to give for latched_job().
inline const std::string& latched_hash() { return expected_hash(latched_job({"--integrator", "path"})); }

class LatchedFarm : public FarmUnderTest {
 public:
  /// Units that a worker renders before it waits.
  static constexpr std::uint32_t kFreeUnits = 2;

  /// A worker of one thread.
  support::Process& add_latched_worker(const std::string& name = {}) {
    return add_worker(WorkerSetup{
        .name = name,
        .environment = {std::string(kLatchVariable) + "=" + std::to_string(kFreeUnits) + ":" + file()}});
  }

  /// Waits until `workers` workers have rendered all that they may, and hold the next unit.
  v1::JobStatus wait_at_the_latch(const std::string& job_id, std::uint32_t workers,
                                  std::set<std::uint32_t>* acknowledged = nullptr) {
    return watch_until(
        job_id,
        [&](const v1::JobStatus& status) {
          return status.units_done() >= workers * kFreeUnits && status.units_leased() >= workers;
        },
        acknowledged);
  }

  /// Lets all workers go on.
  void open() { std::ofstream{file()} << "open\n"; }

 private:
  std::string file() const { return (directory() / "latch").string(); }
};

}  // namespace tessera::integration
