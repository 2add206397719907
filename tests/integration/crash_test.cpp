// Nothing is lost when a process dies.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "integration/latched_farm.h"

namespace tessera::integration {
namespace {

/// How often a worker says that it rendered the unit.
std::size_t times_rendered(const support::Process& worker, std::uint32_t unit, const std::string& job_id) {
  const std::string line = "unit " + std::to_string(unit) + " of job " + job_id + " rendered";
  const std::string log = worker.err();
  std::size_t times = 0;
  for (std::size_t at = log.find(line); at != std::string::npos; at = log.find(line, at + 1)) ++times;
  return times;
}

class Crash : public WithLatch {};

/// `tessera submit` that waits for the picture.
support::Process submit_and_wait(const FarmUnderTest& farm, const std::string& image) {
  Arguments arguments = farm.on_farm(latched_job());
  arguments.insert(arguments.begin(), {tessera_program(), "submit"});
  arguments.erase(std::find(arguments.begin(), arguments.end(), "--quiet"));
  arguments.insert(arguments.end(), {"-o", image});
  return support::Process{arguments};
}

TEST_F(Crash, AKilledWorkerLosesNothing) {
  LatchedFarm farm;
  farm.add_latched_worker();
  farm.add_latched_worker();
  const std::string job_id = farm.submit_detached(latched_job());
  ASSERT_EQ(farm.wait_at_the_latch(job_id, 2).state(), v1::RUNNING);
  farm.worker(0).kill();
  farm.open();
  EXPECT_EQ(farm.fetch_hash(job_id), latched_hash());
}

TEST_F(Crash, AKilledWorkerAndAKilledCoordinatorLoseNothing) {
  LatchedFarm farm;
  // All have one name, and so one host: no host audits itself, which would be rendering again.
  farm.add_latched_worker("host");
  farm.add_latched_worker("host");
  const std::string job_id = farm.submit_detached(latched_job());
  std::set<std::uint32_t> acknowledged;
  const v1::JobStatus before = farm.wait_at_the_latch(job_id, 2, &acknowledged);
  ASSERT_EQ(before.state(), v1::RUNNING);
  ASSERT_FALSE(acknowledged.empty());
  farm.kill_coordinator();
  farm.kill_worker(0);
  farm.restart_coordinator();

  const auto after = farm.client().job(job_id, {});
  ASSERT_TRUE(after.ok()) << after.status();
  EXPECT_GE(after->status().units_done(), before.units_done());
  farm.open();
  EXPECT_EQ(farm.fetch_hash(job_id), latched_hash());
  for (const std::uint32_t unit : acknowledged) {
    EXPECT_EQ(times_rendered(farm.worker(0), unit, job_id) + times_rendered(farm.worker(1), unit, job_id), 1U)
        << "unit " << unit << " was acknowledged before the crash";
  }
}

TEST_F(Crash, AClientThatWaitsOutlivesACoordinatorRestart) {
  LatchedFarm farm;
  farm.add_latched_worker();
  const std::string image = (farm.directory() / "image.exr").string();
  support::Process waiting = submit_and_wait(farm, image);
  const std::optional<std::string> job_id = waiting.wait_for_line("job ", kPatience);
  ASSERT_TRUE(job_id) << waiting.err();
  farm.wait_at_the_latch(*job_id, 1);
  farm.kill_and_restart_coordinator();
  farm.open();
  const std::optional<support::ExitStatus> ended = waiting.wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->code, 0) << waiting.err();
  EXPECT_EQ(pixel_sha256(image), latched_hash());
}

TEST_F(Crash, TheImageOfAKilledClientCanBeFetched) {
  LatchedFarm farm;
  farm.add_latched_worker();
  support::Process waiting = submit_and_wait(farm, (farm.directory() / "never.exr").string());
  const std::optional<std::string> job_id = waiting.wait_for_line("job ", kPatience);
  ASSERT_TRUE(job_id) << waiting.err();
  farm.wait_at_the_latch(*job_id, 1);
  waiting.kill();
  farm.open();
  EXPECT_EQ(farm.fetch_hash(*job_id), latched_hash());
}

TEST_F(Crash, AnInterruptedClientSaysHowToComeBack) {
  LatchedFarm farm;  // without workers: nothing ends the job
  support::Process waiting = submit_and_wait(farm, "image.exr");
  const std::optional<std::string> job_id = waiting.wait_for_line("job ", kPatience);
  ASSERT_TRUE(job_id) << waiting.err();
  waiting.send_signal(SIGINT);
  const std::optional<support::ExitStatus> ended = waiting.wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->code, 130);
  EXPECT_NE(waiting.err().find("tessera fetch " + *job_id + " -o image.exr"), std::string::npos)
      << waiting.err();
  const auto job = farm.client().job(*job_id, {});
  ASSERT_TRUE(job.ok()) << job.status();
  EXPECT_FALSE(client::has_ended(job->status().state()));
}

TEST_F(Crash, AWorkerThatIsAskedToStopGivesItsUnitsBack) {
  LatchedFarm farm;
  support::Process& leaving = farm.add_latched_worker();
  const std::string job_id = farm.submit_detached(latched_job());
  ASSERT_EQ(farm.wait_at_the_latch(job_id, 1).state(), v1::RUNNING);
  leaving.send_signal(SIGTERM);
  farm.open();
  const std::optional<support::ExitStatus> ended = leaving.wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->code, 0) << leaving.err();
  const auto workers = farm.client().workers({});
  ASSERT_TRUE(workers.ok()) << workers.status();
  for (const v1::WorkerStatus& worker : *workers) EXPECT_EQ(worker.leases(), 0U);
  farm.add_latched_worker();
  EXPECT_EQ(farm.fetch_hash(job_id), latched_hash());
}

}  // namespace
}  // namespace tessera::integration
