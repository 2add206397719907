// Programs that stand still, and clocks that jump.
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <regex>
#include <thread>

#include "integration/farm_under_test.h"
#include "support/long_form.h"
#include "support/needs.h"

namespace tessera::integration {
namespace {

using std::chrono::seconds;

const Arguments kStoppedJob = in_many_units("160", "256");

/// TESSERA_STOP_SECONDS=60 is the form that is run by hand.
seconds pause_of(int in_short_form) {
  return seconds{test::how_often("TESSERA_STOP_SECONDS", static_cast<std::uint64_t>(in_short_form), 20)};
}

void stop_for(support::Process& process, seconds pause) {
  process.send_signal(SIGSTOP);
  std::this_thread::sleep_for(pause);
  process.send_signal(SIGCONT);
}

TEST(Standstill, AWorkerForLongerThanItsLeases) {
  FarmUnderTest farm;
  farm.add_worker(1);
  farm.add_worker(1);
  const std::string job_id = farm.submit_detached(kStoppedJob);
  farm.watch_until(job_id, a_quarter_is_done);
  stop_for(farm.worker(0), pause_of(10));
  EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(kStoppedJob));
  EXPECT_TRUE(farm.client().job(job_id, {})->status().set_aside().empty());
}

TEST(Standstill, TheOnlyWorkerForLessThanItsLeases) {
  FarmUnderTest farm;
  farm.add_worker(1);
  const std::string job_id = farm.submit_detached(kStoppedJob);
  farm.watch_until(job_id, a_quarter_is_done);
  stop_for(farm.worker(0), pause_of(3));
  EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(kStoppedJob));
}

TEST(Standstill, TheCoordinator) {
  FarmUnderTest farm;
  farm.add_worker(1);
  farm.add_worker(1);
  const std::string job_id = farm.submit_detached(kStoppedJob);
  farm.watch_until(job_id, a_quarter_is_done);
  stop_for(farm.coordinator(), pause_of(10));
  EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(kStoppedJob));
  EXPECT_TRUE(farm.client().job(job_id, {})->status().set_aside().empty()) << "nobody is to blame";
}

/// Lets a program run for a tenth of the time.
class Throttle {
 public:
  explicit Throttle(support::Process& process)
      : thread_([&process](std::stop_token halt) {
          while (!halt.stop_requested()) {
            process.send_signal(SIGSTOP);
            std::this_thread::sleep_for(std::chrono::milliseconds{90});
            process.send_signal(SIGCONT);
            std::this_thread::sleep_for(std::chrono::milliseconds{10});
          }
        }) {}

 private:
  std::jthread thread_;
};

/// For how long all threads of a program ran, or would have run had there been a core for them.
double busy_seconds(const support::Process& process) {
  double busy = 0;
  const std::filesystem::path tasks = "/proc/" + std::to_string(process.id()) + "/task";
  for (const auto& task : std::filesystem::directory_iterator{tasks}) {
    double ran = 0, waited = 0;  // ns
    std::ifstream{task.path() / "schedstat"} >> ran >> waited;
    busy += (ran + waited) / 1e9;
  }
  return busy;
}

/// Units that a worker has begun, as it says when it leaves.
std::uint64_t units_begun(support::Process& worker) {
  worker.send_signal(SIGTERM);
  EXPECT_TRUE(worker.wait(kPatience));
  const std::string log = worker.err();
  std::smatch said;
  EXPECT_TRUE(std::regex_search(log, said, std::regex{"(\\d+) units rendered, (\\d+) stopped"})) << log;
  return said.empty() ? 0 : std::stoull(said[1]) + std::stoull(said[2]);
}

TEST(Standstill, AWorkerThatRunsForATenthOfTheTimeKeepsNobodyWaiting) {
  if (!test::long_form()) GTEST_SKIP() << "in a short job the last unit is too large a part of the time";
  FarmUnderTest farm;
  for (int i = 0; i < 3; ++i) farm.add_worker(1);
  const Arguments job{
      "scenes/cornell-box/scene.pbrt", "--resolution", "256x256", "--spp", "512", "--tile", "8", "--quiet"};
  const Throttle throttle{farm.worker(2)};
  const std::string job_id = farm.submit_detached(job);
  farm.watch_until(job_id, [](const v1::JobStatus& status) { return status.units_done() > 0; });
  const auto begin = std::chrono::steady_clock::now();
  const double busy_before = busy_seconds(farm.worker(0)) + busy_seconds(farm.worker(1));
  const v1::JobStatus end = farm.watch_until(job_id, [](const v1::JobStatus&) { return false; });
  const double busy = busy_seconds(farm.worker(0)) + busy_seconds(farm.worker(1)) - busy_before;
  const double makespan = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  ASSERT_EQ(end.state(), v1::DONE);

  // Ideal: the fast ones never wait, and the slow one does its tenth.
  const double over_ideal = makespan / (busy / 2) * (2.1 / 2);
  std::uint64_t begun = 0;
  for (std::size_t i = 0; i < 3; ++i) begun += units_begun(farm.worker(i));
  const double twice = static_cast<double>(begun) / end.units_total() - 1;
  std::printf("%.1f s, %.3f of ideal; %.1f %% of the units begun twice\n", makespan, over_ideal, 100 * twice);
  EXPECT_LE(twice, 0.02);
  EXPECT_LE(over_ideal, 1.15);
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
    return {"LD_PRELOAD=" + library(), "FAKETIME_TIMESTAMP_FILE=" + file_.string(),
            "FAKETIME_CACHE_DURATION=1", "FAKETIME_DONT_FAKE_MONOTONIC=1"};
  }

 private:
  const std::filesystem::path file_;
};

TEST(Standstill, ClocksJumpByAnHour) {
  if (FalseClock::library().empty()) GTEST_SKIP() << test::needs("libfaketime");
  const support::TempDir directory;
  FalseClock of_coordinator{directory.path() / "coordinator"}, of_worker{directory.path() / "worker"};
  FarmUnderTest farm{{}, of_coordinator.environment()};
  farm.add_worker(WorkerSetup{.environment = of_worker.environment()});
  farm.add_worker(1);
  using Steps = std::pair<const char*, const char*>;
  for (const auto& [coordinator, worker] :
       {Steps{"+3600", "-3600"}, Steps{"-3600", "+3600"}, Steps{"+0", "+0"}}) {
    const std::string job_id = farm.submit_detached(kStoppedJob + Arguments{"--fresh"});
    farm.watch_until(job_id, a_quarter_is_done);
    of_coordinator.set(coordinator);
    of_worker.set(worker);
    EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(kStoppedJob)) << coordinator << ' ' << worker;
    if (!test::long_form()) break;
  }
}

TEST(Standstill, AClockThatIsSetBy400DaysDeletesNoJob) {
  if (FalseClock::library().empty()) GTEST_SKIP() << test::needs("libfaketime");
  const support::TempDir directory;
  FalseClock clock{directory.path() / "coordinator"};
  FarmUnderTest farm{{}, clock.environment()};
  farm.add_worker(1);
  const Arguments job{"scenes/cornell-box/scene.pbrt", "--resolution", "32x32", "--spp", "4", "--quiet"};
  const std::string job_id = farm.submit_detached(job);
  EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(job));
  clock.set("+" + std::to_string(400 * 24 * 3600));
  ASSERT_TRUE(farm.coordinator().wait_for_err("the machine's clock was set by", kPatience))
      << farm.coordinator().err();
  // It looks every 15 s for jobs whose time is over.
  EXPECT_FALSE(farm.coordinator().wait_for_err("its time is over", seconds{17})) << farm.coordinator().err();
  EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(job));
  farm.kill_and_restart_coordinator();
  EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(job));
}

}  // namespace
}  // namespace tessera::integration
