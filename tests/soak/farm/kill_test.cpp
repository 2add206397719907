// kill -9, again and again, at random and at the worst of times. TESSERA_KILLS=N in the environment kills
// that often, TESSERA_SEED=N otherwise than by default.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <random>
#include <thread>

#include "integration/farm_under_test.h"
#include "support/long_form.h"
#include "support/process/file_watch.h"

namespace tessera::integration {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;
using std::chrono::seconds;

// Many units of some 10 ms, so that a kill costs little.
const Arguments kManyUnits = in_many_units("160", "64", "8");
// Kills of one job, that it ends some day.
constexpr int kKillsAJob = 40;
// After its worker's death a unit is with another one (docs/farm.md: a lease runs out within 8 s).
constexpr milliseconds kReassigned = seconds{15};

class Chance {
 public:
  explicit Chance(std::uint64_t seed) : random_(seed) {}
  int below(int n) { return std::uniform_int_distribution<int>{0, n - 1}(random_); }
  void pause(int at_most_ms) { std::this_thread::sleep_for(milliseconds{below(at_most_ms + 1)}); }

 private:
  std::mt19937_64 random_;
};

std::uint64_t seed() { return test::how_often("TESSERA_SEED", 1, 2); }

void expect_whole(FarmUnderTest& farm, const std::string& job_id, int& retries) {
  const v1::JobStatus end = farm.watch_to_the_end(job_id, &retries);
  ASSERT_EQ(end.state(), v1::DONE) << end.error();
  EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(kManyUnits));
}

bool over(FarmUnderTest& farm, const std::string& job_id) {
  const auto job = farm.client().job(job_id, {});
  EXPECT_TRUE(job.ok()) << job.status();
  return !job.ok() || client::has_ended(job->status().state());
}

/// Kills one of the workers while it fetches or builds the scene, while it delivers results, or at any time.
void kill_a_worker(FarmUnderTest& farm, int workers, Chance& chance) {
  const auto victim = static_cast<std::size_t>(chance.below(workers));
  switch (chance.below(3)) {
    case 0:
      farm.worker(victim).wait_for_err("registered with", seconds{3});
      chance.pause(40);
      break;
    case 1:
      farm.worker(victim).wait_for_err(" rendered", seconds{1});
      chance.pause(5);
      break;
    default:
      chance.pause(500);
  }
  farm.kill_worker(victim);
  if (chance.below(3) == 0)
    std::filesystem::remove_all(farm.cache_of(victim));  // a new cache has something to fetch
  farm.restart_worker(victim);
}

TEST(Kill, WorkersAtAnyTimeAndTheImageIsTheSame) {
  constexpr int kWorkers = 3;
  const int kills = static_cast<int>(test::how_often("TESSERA_KILLS", 12, 100));
  Chance chance{seed()};
  FarmUnderTest farm;
  // All are of one host: as many deaths in a minute as here would otherwise speak against the units.
  for (int i = 0; i < kWorkers; ++i) farm.add_worker(1, "host");
  int done = 0, jobs = 0, retries = 0;
  while (done < kills && !HasFailure()) {
    const std::string job_id = farm.submit_detached(kManyUnits + Arguments{"--fresh"});
    ++jobs;
    for (int here = 0; done < kills && here < kKillsAJob && !over(farm, job_id); ++here, ++done) {
      kill_a_worker(farm, kWorkers, chance);
      const auto workers = farm.client().workers({});
      ASSERT_TRUE(workers.ok()) << workers.status();
      for (const v1::WorkerStatus& worker : *workers) {
        EXPECT_LT(worker.last_seen_ms_ago(), kReassigned.count()) << "a dead worker still has its units";
      }
    }
    expect_whole(farm, job_id, retries);
  }
  std::printf("%d workers killed (seed %d) in %d jobs; units were set aside and retried %d times\n", done,
              static_cast<int>(seed()), jobs, retries);
}

TEST(Kill, TheUnitsOfADeadWorkerAreGivenToOthers) {
  FarmUnderTest farm;
  support::Process& victim = farm.add_worker(1);
  // More units than are ever out, so that nothing is copied; nobody finishes one in this test.
  const std::string job_id = farm.submit_detached(
      {"scenes/cornell-box/scene.pbrt", "--resolution", "1024x1024", "--spp", "65536", "--tile", "128"});
  farm.watch_until(job_id, [](const v1::JobStatus& status) { return status.units_leased() > 0; });
  ASSERT_TRUE(victim.wait_for_err("loaded in", kPatience)) << victim.err();
  farm.kill_worker(0);
  const Clock::time_point killed = Clock::now();
  const v1::JobStatus given_up =
      farm.watch_until(job_id, [](const v1::JobStatus& status) { return status.units_leased() == 0; });
  EXPECT_EQ(given_up.units_leased(), 0U);
  farm.add_worker(1);
  farm.watch_until(job_id, [](const v1::JobStatus& status) { return status.units_leased() > 0; });
  const double took = std::chrono::duration<double>(Clock::now() - killed).count();
  EXPECT_LT(took, std::chrono::duration<double>(kReassigned).count());
  std::printf("given to another worker after %.1f s\n", took);
  EXPECT_EQ(tessera(farm.on_farm({"cancel", job_id})).status.code, 0);
}

// ---------------------------------------------------------------- the coordinator

/// Notes which units workers lease and render, and when a client hears that one is acknowledged.
class Witness {
 public:
  Witness(FarmUnderTest& farm, const std::string& job_id, std::size_t workers)
      : farm_(farm), job_id_(job_id), client_(farm.new_client()), read_(workers, 0) {
    for (std::size_t i = 0; i < workers; ++i) read_[i] = farm.worker(i).err().size();
    watching_ = std::jthread{[this](std::stop_token stop) { watch(stop); }};
    listening_ = std::jthread{[this](std::stop_token stop) {
      while (!stop.stop_requested()) {
        listen();
        std::this_thread::sleep_for(milliseconds{20});
      }
      listen();
    }};
  }

  struct Report {
    std::size_t acknowledged = 0, renderings = 0;
    std::vector<std::uint32_t> again;  // leased after they were acknowledged
  };
  /// After the job's end.
  Report report() {
    watching_.join();
    listening_.request_stop();
    listening_.join();
    // The first lines may be older than this witness, and the last ones on their way.
    EXPECT_GT(2 * renderings_, acknowledged_.size()) << "the workers' logs are not understood";
    EXPECT_GT(2 * leased_.size(), acknowledged_.size());
    Report report{.acknowledged = acknowledged_.size(), .renderings = renderings_, .again = {}};
    for (const auto& [unit, time] : leased_) {
      const auto known = acknowledged_.find(unit);
      if (known != acknowledged_.end() && time > known->second + kNewsTravels) report.again.push_back(unit);
    }
    return report;
  }

 private:
  // On a busy machine a line of a log is read long after it was written.
  static constexpr seconds kNewsTravels{2};

  void watch(std::stop_token stop) {
    client::FarmClient::WatchHandlers handlers;
    handlers.result = [&](const v1::UnitResult& result) {
      acknowledged_.emplace(result.unit().index(), Clock::now());
      return absl::OkStatus();
    };
    const auto end = client_->watch(job_id_, handlers, stop);
    EXPECT_TRUE(end.ok()) << end.status();
  }

  void listen() {
    const std::string before = "unit ", job = " of job " + job_id_;
    for (std::size_t i = 0; i < read_.size(); ++i) {
      const std::string log = farm_.worker(i).err(read_[i]);
      std::size_t line = 0;
      for (std::size_t end; (end = log.find('\n', line)) != std::string::npos; line = end + 1) {
        const std::string text = log.substr(line, end - line);
        const std::size_t at = text.find(before), behind = text.find(job);
        if (at == std::string::npos || behind == std::string::npos) continue;
        const std::string what = text.substr(behind + job.size());
        if (what.starts_with(" rendered")) ++renderings_;
        if (what.starts_with(" leased"))
          leased_.emplace_back(std::stoul(text.substr(at + before.size())), Clock::now());
      }
      read_[i] += line;
    }
  }

  FarmUnderTest& farm_;
  const std::string job_id_;
  const std::unique_ptr<client::FarmClient> client_;
  std::vector<std::size_t> read_;  // bytes read of each worker's log
  // Used by the listening thread.
  std::vector<std::pair<std::uint32_t, Clock::time_point>> leased_;
  std::size_t renderings_ = 0;
  // Used by the watching thread.
  std::map<std::uint32_t, Clock::time_point> acknowledged_;
  std::jthread watching_, listening_;
};

/// Waits until the job makes progress, and then for the moment in which the coordinator is to die: in the
/// midst of a write of results or of the journal, or any other. False when the job ended before.
bool wait_for_the_moment(FarmUnderTest& farm, const std::string& job_id, Chance& chance) {
  const auto now = farm.client().job(job_id, {});
  EXPECT_TRUE(now.ok()) << now.status();
  if (!now.ok()) return false;
  const std::uint32_t done = now->status().units_done();
  const v1::JobStatus status =
      farm.watch_until(job_id, [&](const v1::JobStatus& later) { return later.units_done() > done; });
  if (client::has_ended(status.state())) return false;
  switch (chance.below(3)) {
    case 0: {
      support::FileWatch results{farm.data_dir() / "results" / job_id};
      results.wait(milliseconds{500});
      break;
    }
    case 1: {
      support::FileWatch journal{farm.data_dir() / "journal.sqlite-wal"};
      journal.wait(milliseconds{500});
      break;
    }
    default:
      chance.pause(200);
  }
  // The write that was heard of, the sync behind it, or the next.
  std::this_thread::sleep_for(std::chrono::microseconds{chance.below(800)});
  return true;
}

TEST(Kill, TheCoordinatorAtAnyTimeAlsoWithinACommit) {
  const int kills = static_cast<int>(test::how_often("TESSERA_KILLS", 6, 40));
  Chance chance{seed()};
  FarmUnderTest farm;
  // Both are of one host: no host audits itself, which would be rendering again.
  farm.add_worker(1, "host");
  farm.add_worker(1, "host");
  int done = 0, jobs = 0, retries = 0;
  std::size_t acknowledged = 0, renderings = 0;
  double slowest_start = 0;
  while (done < kills && !HasFailure()) {
    const std::string job_id = farm.submit_detached(kManyUnits + Arguments{"--fresh"});
    ++jobs;
    Witness witness{farm, job_id, 2};
    while (done < kills && wait_for_the_moment(farm, job_id, chance)) {
      farm.kill_coordinator();
      const Clock::time_point start = Clock::now();
      farm.restart_coordinator();
      slowest_start = std::max(slowest_start, std::chrono::duration<double>(Clock::now() - start).count());
      ++done;
    }
    expect_whole(farm, job_id, retries);
    const Witness::Report report = witness.report();
    EXPECT_TRUE(report.again.empty()) << report.again.size() << " units were given out again";
    EXPECT_EQ(report.acknowledged, 400U);
    acknowledged += report.acknowledged;
    renderings += report.renderings;
  }
  EXPECT_EQ(retries, 0);
  std::printf(
      "coordinator killed %d times (seed %d) in %d jobs; %zu units acknowledged, %zu renderings; "
      "listening again after %.2f s at most\n",
      done, static_cast<int>(seed()), jobs, acknowledged, renderings, slowest_start);
}

TEST(Kill, WorkersGoOnWhileThereIsNoCoordinatorAndDeliverLater) {
  FarmUnderTest farm;
  support::Process& worker = farm.add_worker(2);
  // Units of some 0.1 s, far more than are done before the kill; a worker of two threads has up to six in
  // hand.
  const std::string job_id = farm.submit_detached(
      {"scenes/cornell-box/scene.pbrt", "--resolution", "64x64", "--spp", "8192", "--tile", "32", "--quiet"});
  Witness witness{farm, job_id, 1};
  farm.watch_until(job_id, [](const v1::JobStatus& status) { return status.units_done() > 2; });
  const auto rendered = [&] {
    const std::string log = worker.err(), what = " rendered";
    std::size_t times = 0;
    for (std::size_t at = log.find(what); at != std::string::npos; at = log.find(what, at + 1)) ++times;
    return times;
  };
  farm.kill_coordinator();
  const std::size_t before = rendered();
  const Clock::time_point killed = Clock::now();
  while (rendered() < before + 2 && Clock::now() - killed < kPatience)
    std::this_thread::sleep_for(milliseconds{50});
  EXPECT_GE(rendered(), before + 2) << worker.err();
  farm.restart_coordinator();
  const v1::JobStatus end = farm.watch_until(job_id, [](const v1::JobStatus&) { return false; });
  ASSERT_EQ(end.state(), v1::DONE) << end.error();
  const Witness::Report report = witness.report();
  EXPECT_EQ(report.renderings, report.acknowledged) << "what was rendered meanwhile was rendered again";
}

}  // namespace
}  // namespace tessera::integration
