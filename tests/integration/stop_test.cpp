// Programs that stand still, and clocks that jump.
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "integration/farm_under_test.h"
#include "support/long_form.h"

namespace tessera::integration {
namespace {

using std::chrono::seconds;

const Arguments kJob{
    "scenes/cornell-box/scene.pbrt", "--resolution", "160x160", "--spp", "256", "--tile", "16", "--quiet"};

bool a_quarter_is_done(const v1::JobStatus& status) {
  return status.units_total() > 0 && 4 * status.units_done() >= status.units_total();
}

/// TESSERA_STOP_SECONDS=60 is the form that is run by hand.
seconds pause_of(int in_short_form) {
  return seconds{test::how_often("TESSERA_STOP_SECONDS", static_cast<std::uint64_t>(in_short_form), 20)};
}

void stop_for(support::Process& process, seconds pause) {
  process.send_signal(SIGSTOP);
  std::this_thread::sleep_for(pause);
  process.send_signal(SIGCONT);
}

TEST(Stop, AWorkerForLongerThanItsLeases) {
  FarmUnderTest farm;
  farm.add_worker(1);
  farm.add_worker(1);
  const std::string job_id = farm.submit_detached(kJob);
  farm.watch_until(job_id, a_quarter_is_done);
  stop_for(farm.worker(0), pause_of(10));
  EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(kJob));
  EXPECT_TRUE(farm.client().job(job_id, {})->status().set_aside().empty());
}

TEST(Stop, TheOnlyWorkerForLessThanItsLeases) {
  FarmUnderTest farm;
  farm.add_worker(1);
  const std::string job_id = farm.submit_detached(kJob);
  farm.watch_until(job_id, a_quarter_is_done);
  stop_for(farm.worker(0), pause_of(3));
  EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(kJob));
}

TEST(Stop, TheCoordinator) {
  FarmUnderTest farm;
  farm.add_worker(1);
  farm.add_worker(1);
  const std::string job_id = farm.submit_detached(kJob);
  farm.watch_until(job_id, a_quarter_is_done);
  stop_for(farm.coordinator(), pause_of(10));
  EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(kJob));
  EXPECT_TRUE(farm.client().job(job_id, {})->status().set_aside().empty()) << "nobody is to blame";
}

/// The clock on the wall of a program, as its own library shows it.
class FalseClock {
 public:
  explicit FalseClock(const std::filesystem::path& file) : file_(file) { set("+0"); }
  /// An offset to the true time: "+3600".
  void set(const std::string& offset) {
    const std::filesystem::path next = file_.string() + ".next";
    std::ofstream{next} << offset << '\n';
    std::filesystem::rename(next, file_);
  }
  /// Empty when the library is not installed.
  static std::string library() {
    for (const char* path : {"/usr/lib/x86_64-linux-gnu/faketime/libfaketimeMT.so.1",
                             "/usr/lib/aarch64-linux-gnu/faketime/libfaketimeMT.so.1"}) {
      if (std::filesystem::exists(path)) return path;
    }
    return "";
  }
  std::vector<std::string> environment() const {
    return {"LD_PRELOAD=" + library(), "FAKETIME_TIMESTAMP_FILE=" + file_.string(), "FAKETIME_CACHE_DURATION=1",
            "FAKETIME_DONT_FAKE_MONOTONIC=1"};
  }

 private:
  const std::filesystem::path file_;
};

TEST(Stop, ClocksJumpByAnHour) {
  if (FalseClock::library().empty()) GTEST_SKIP() << "libfaketime is not installed";
  const support::TempDir directory;
  FalseClock of_coordinator{directory.path() / "coordinator"}, of_worker{directory.path() / "worker"};
  FarmUnderTest farm{{}, of_coordinator.environment()};
  farm.add_worker(WorkerSetup{.environment = of_worker.environment()});
  farm.add_worker(1);
  using Steps = std::pair<const char*, const char*>;
  for (const auto& [coordinator, worker] : {Steps{"+3600", "-3600"}, Steps{"-3600", "+3600"}, Steps{"+0", "+0"}}) {
    const std::string job_id = farm.submit_detached(kJob + Arguments{"--fresh"});
    farm.watch_until(job_id, a_quarter_is_done);
    of_coordinator.set(coordinator);
    of_worker.set(worker);
    EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(kJob)) << coordinator << ' ' << worker;
    if (!test::long_form()) break;
  }
}

}  // namespace
}  // namespace tessera::integration
