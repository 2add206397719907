// Equal workers, and work that waits: nobody stands still, and nobody is taken for slow.
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "integration/farm_under_test.h"
#include "support/long_form.h"
#include "support/needs.h"
#include "support/picture/unpacked_corpus.h"

namespace tessera::integration {
namespace {

constexpr std::size_t kIdleWorkers = 6;
// In use, up to five of six had held nothing from the first job on.
constexpr double kMostIdle = 0.02;
constexpr double kPaceTolerance = 0.2;
// Enough to tell 2 % from none.
constexpr std::uint64_t kLooks = 50 * kIdleWorkers;
constexpr int kMostJobs = 100;

/// How often workers were looked at while units of the job waited, how often one of them held none, and when.
struct Watched {
  std::uint64_t looks = 0, idle = 0;
  std::string when;
};

/// How far a job has come.
std::string progress(const v1::JobStatus& status) {
  return std::to_string(status.units_done()) + " units done, " + std::to_string(status.units_leased()) +
         " leased, " + std::to_string(status.units_waiting()) + " waiting";
}

void watch(FarmUnderTest& farm, const std::string& job_id, Watched& watched) {
  const auto end = std::chrono::steady_clock::now() + 10 * kPatience;
  while (std::chrono::steady_clock::now() < end) {
    const auto job = farm.client().job(job_id, {});
    ASSERT_TRUE(job.ok()) << job.status();
    if (job->status().state() != v1::RUNNING && job->status().state() != v1::QUEUED) {
      EXPECT_EQ(job->status().state(), v1::DONE);
      return;
    }
    const auto workers = farm.client().workers({});
    ASSERT_TRUE(workers.ok()) << workers.status();
    // Both before and after the workers were looked at.
    const auto still = farm.client().job(job_id, {});
    ASSERT_TRUE(still.ok()) << still.status();
    const auto waiting = [](const v1::JobStatus& s) {
      return s.state() == v1::RUNNING && s.units_waiting() > 0;
    };
    if (waiting(job->status()) && waiting(still->status())) {
      std::string idle;
      for (const v1::WorkerStatus& worker : *workers) {
        ++watched.looks;
        if (worker.leases() > 0) continue;
        ++watched.idle;
        idle += worker.name() + " ";
      }
      if (!idle.empty())
        watched.when +=
            idle + "idle between " + progress(job->status()) + " and " + progress(still->status()) + "\n";
    }
    std::this_thread::sleep_for(std::chrono::milliseconds{20});  // between looks; nothing waits for it
  }
  ADD_FAILURE() << "job " << job_id << " does not end";
}

/// Three jobs of the scene, or as many as it takes to tell something, one after the other on six workers of
/// one thread.
void expect_nobody_idle(const std::string& scene, const Arguments& options) {
  SCOPED_TRACE(scene);
  // Units of a tenth of a second: every worker returns dozens, however short the job.
  FarmUnderTest farm({}, {}, "127.0.0.1", {"--unit-seconds", "0.1"});
  for (std::size_t i = 0; i < kIdleWorkers; ++i) farm.add_worker(1);
  Watched watched;
  for (int seed = 1; seed <= 3 || (watched.looks <= kLooks && seed <= kMostJobs); ++seed) {
    const std::string job = farm.submit_detached(Arguments{scene, "--seed", std::to_string(seed)} + options);
    watch(farm, job, watched);
    if (testing::Test::HasFatalFailure()) return;
  }
  ASSERT_GT(watched.looks, kLooks) << "too short to tell anything";
  const double idle = static_cast<double>(watched.idle) / static_cast<double>(watched.looks);
  testing::Test::RecordProperty("idle", std::to_string(idle));
  EXPECT_LT(idle, kMostIdle) << watched.idle << " of " << watched.looks << ":\n" << watched.when;
  const auto workers = farm.client().workers({});
  ASSERT_TRUE(workers.ok()) << workers.status();
  ASSERT_EQ(workers->size(), kIdleWorkers);
  for (const v1::WorkerStatus& worker : *workers) {
    std::printf("%s: %s has done %llu units, slowness %.3f; idle %.4f\n", scene.c_str(),
                worker.name().c_str(), static_cast<unsigned long long>(worker.units_done()),
                worker.slowness(), idle);
    EXPECT_NEAR(worker.slowness(), 1, kPaceTolerance) << worker.name();
  }
}

TEST(Idle, EqualWorkersHoldWorkWhileThereIsSome) {
  expect_nobody_idle("scenes/first-light/scene.textproto", {"--spp", "64"});
  expect_nobody_idle("scenes/cornell-box/scene.pbrt", {"--spp", "64"});
}

TEST(Idle, OnScenesOfTheCorpus) {
  if (!test::long_form()) GTEST_SKIP() << "in the long form only";
  // Jobs of some seconds: how one begins is not the question.
  struct Scene {
    const char *name, *spp;
  };
  for (const auto& [name, spp] :
       {Scene{"classroom", "96"}, Scene{"coffee", "96"}, Scene{"hair-curl", "1024"}, Scene{"staircase", "96"},
        Scene{"veach-mis", "96"}, Scene{"volumetric-caustic", "96"}, Scene{"water-caustic", "96"}}) {
    const auto folder = test::find_corpus(std::string("pbrt/") + name);
    if (!folder) GTEST_SKIP() << test::needs("../shared/scenes");
    expect_nobody_idle((folder->path() / "scene.pbrt").string(), {"--spp", spp, "--resolution", "320x180"});
  }
}

}  // namespace
}  // namespace tessera::integration
