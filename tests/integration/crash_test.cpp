// Nothing is lost when a process dies.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "integration/farm_under_test.h"

namespace tessera::integration {
namespace {

// Some seconds of work in many units.
const Arguments kSomeSeconds = in_many_units("160", "256");

bool a_third_is_done(const v1::JobStatus& status) {
  return status.units_total() > 0 && 3 * status.units_done() >= status.units_total();
}

/// How often a worker says that it rendered the unit.
std::size_t times_rendered(const support::Process& worker, std::uint32_t unit, const std::string& job_id) {
  const std::string line = "unit " + std::to_string(unit) + " of job " + job_id + " rendered";
  const std::string log = worker.err();
  std::size_t times = 0;
  for (std::size_t at = log.find(line); at != std::string::npos; at = log.find(line, at + 1)) ++times;
  return times;
}

TEST(Crash, AKilledWorkerLosesNothing) {
  FarmUnderTest farm;
  farm.add_worker(1);
  farm.add_worker(1);
  const std::string job_id = farm.submit_detached(kSomeSeconds);
  const v1::JobStatus third = farm.watch_until(job_id, a_third_is_done);
  ASSERT_EQ(third.state(), v1::RUNNING) << "the job was over before a worker could be killed";
  farm.worker(0).kill();
  EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(kSomeSeconds));
}

TEST(Crash, AKilledCoordinatorGoesOnWhereItWas) {
  FarmUnderTest farm;
  // All have one name, and so one host: no host audits itself, which would be rendering again.
  farm.add_worker(1, "host");
  farm.add_worker(1, "host");
  const std::string job_id = farm.submit_detached(kSomeSeconds);
  std::set<std::uint32_t> acknowledged;
  const v1::JobStatus before = farm.watch_until(job_id, a_third_is_done, &acknowledged);
  ASSERT_EQ(before.state(), v1::RUNNING) << "the job was over before the coordinator could be killed";
  ASSERT_FALSE(acknowledged.empty());
  farm.kill_and_restart_coordinator();

  const auto after = farm.client().job(job_id, {});
  ASSERT_TRUE(after.ok()) << after.status();
  EXPECT_GE(after->status().units_done(), before.units_done());
  EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(kSomeSeconds));
  for (const std::uint32_t unit : acknowledged) {
    EXPECT_EQ(times_rendered(farm.worker(0), unit, job_id) + times_rendered(farm.worker(1), unit, job_id), 1U)
        << "unit " << unit << " was acknowledged before the crash";
  }
}

TEST(Crash, AClientThatWaitsOutlivesACoordinatorRestart) {
  FarmUnderTest farm;
  farm.add_worker(2);
  const std::string image = (farm.directory() / "image.exr").string();
  Arguments arguments = farm.on_farm(kSomeSeconds);
  arguments.insert(arguments.begin(), {tessera_program(), "submit"});
  arguments.erase(std::find(arguments.begin(), arguments.end(), "--quiet"));
  arguments.insert(arguments.end(), {"-o", image});
  support::Process waiting{arguments};
  const std::optional<std::string> job_id = waiting.wait_for_line("job ", kPatience);
  ASSERT_TRUE(job_id) << waiting.err();
  farm.watch_until(*job_id, a_third_is_done);
  farm.kill_and_restart_coordinator();
  const std::optional<support::ExitStatus> ended = waiting.wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->code, 0) << waiting.err();
  EXPECT_EQ(pixel_sha256(image), expected_hash(kSomeSeconds));
}

TEST(Crash, TheImageOfAKilledClientCanBeFetched) {
  FarmUnderTest farm;
  farm.add_worker(2);
  Arguments arguments = farm.on_farm(kSomeSeconds);
  arguments.insert(arguments.begin(), {tessera_program(), "submit"});
  arguments.erase(std::find(arguments.begin(), arguments.end(), "--quiet"));
  arguments.insert(arguments.end(), {"-o", (farm.directory() / "never.exr").string()});
  support::Process waiting{arguments};
  const std::optional<std::string> job_id = waiting.wait_for_line("job ", kPatience);
  ASSERT_TRUE(job_id) << waiting.err();
  waiting.kill();
  EXPECT_EQ(farm.fetch_hash(*job_id), expected_hash(kSomeSeconds));
}

TEST(Crash, AnInterruptedClientSaysHowToComeBack) {
  FarmUnderTest farm;
  Arguments arguments = farm.on_farm(kSomeSeconds);
  arguments.insert(arguments.begin(), {tessera_program(), "submit"});
  arguments.erase(std::find(arguments.begin(), arguments.end(), "--quiet"));
  arguments.insert(arguments.end(), {"-o", "image.exr"});
  support::Process waiting{arguments};
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

TEST(Crash, AWorkerThatIsAskedToStopGivesItsUnitsBack) {
  FarmUnderTest farm;
  support::Process& leaving = farm.add_worker(1);
  const std::string job_id = farm.submit_detached(kSomeSeconds);
  farm.watch_until(job_id, a_third_is_done);
  leaving.send_signal(SIGTERM);
  const std::optional<support::ExitStatus> ended = leaving.wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->code, 0) << leaving.err();
  const auto workers = farm.client().workers({});
  ASSERT_TRUE(workers.ok()) << workers.status();
  for (const v1::WorkerStatus& worker : *workers) EXPECT_EQ(worker.leases(), 0U);
  farm.add_worker(2);
  EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(kSomeSeconds));
}

}  // namespace
}  // namespace tessera::integration
