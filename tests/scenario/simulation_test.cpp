// Farms of random jobs, workers and mishaps, some thousand seeds. Whatever happens: a unit that was acknowledged is
// never given out again, the first result stays, counts add up, and every job ends.
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

#include "absl/strings/str_cat.h"
#include "scenario/scenario_runner.h"

namespace tessera::server {
namespace {

constexpr Time kTimeout{8000};
constexpr std::size_t kLeasesPerCall = 4;

class Simulation {
 public:
  explicit Simulation(std::uint32_t seed) : random_(seed) {
    const std::uint32_t jobs = 1 + pick(3);
    for (std::uint32_t i = 0; i < jobs; ++i) submit();
  }

  /// Random events; then only honest work, until every job has ended.
  void run() {
    for (int step = 0; step < 150 && !testing::Test::HasFailure(); ++step) {
      misbehave();
      check();
    }
    mishaps_ = false;
    for (int step = 0; step < 2000 && !all_ended() && !testing::Test::HasFailure(); ++step) {
      if (workers_.empty()) join();
      work(workers_.begin()->first);
      pass(Time{100});
      check();
    }
    EXPECT_TRUE(all_ended());
    EXPECT_EQ(scheduler_->leases_out(), 0u);
  }

 private:
  struct Model {
    JobRequest request;
    std::map<std::uint32_t, ResultFingerprint> done;
    bool cancelled = false;
    bool failed = false;
  };
  struct Worker {
    std::vector<v1::LeaseToken> leases;
  };

  std::uint32_t pick(std::uint32_t below) { return static_cast<std::uint32_t>(random_() % below); }

  void submit() {
    const std::string id = absl::StrCat("j", models_.size());
    JobRequest request{.id = id,
                       .plan = row_of_tiles(1 + pick(12), 1 + pick(3)),
                       .scene_digest = absl::StrCat("s", pick(2)),
                       .isa = pick(3) == 0 ? "avx2" : "",
                       .priority = static_cast<std::int32_t>(pick(2))};
    ASSERT_TRUE(scheduler_->add_job(request).ok());
    models_[id] = {.request = request, .done = {}};
  }

  void join() {
    const std::string id = absl::StrCat("w", ++names_);
    ASSERT_TRUE(scheduler_
                    ->register_worker({.id = id,
                                       .name = id,
                                       .build = "",
                                       .isa = pick(2) == 0 ? "avx512" : "avx2",
                                       .supported_isas = {"avx2", "avx512"},
                                       .threads = 1 + pick(4)},
                                      now_)
                    .ok());
    workers_[id] = {};
  }

  void misbehave() {
    switch (pick(16)) {
      case 0:
        return join();
      case 1:
        return pass(Time(pick(12'000)));
      case 2:
        return restart();
      case 3:
        if (!workers_.empty()) workers_.erase(any_worker());  // dies without a word
        return;
      case 4:
        if (pick(8) == 0) cancel();
        return;
      case 5:
        if (models_.size() < 5) submit();
        return;
      default:
        if (workers_.empty()) return join();
        work(any_worker());
        pass(Time(pick(400)));
    }
  }

  const std::string& any_worker() { return std::next(workers_.begin(), pick(workers_.size()))->first; }

  void work(const std::string id) {
    Worker& worker = workers_[id];
    const auto heartbeat = scheduler_->heartbeat(id, worker.leases, now_);
    if (absl::IsNotFound(heartbeat.status())) {
      // Given up, or the coordinator restarted: the same worker under a new name, with its leases.
      Worker moved = std::move(worker);
      workers_.erase(id);
      join();
      workers_[absl::StrCat("w", names_)] = std::move(moved);
      return;
    }
    for (const v1::LeaseToken& revoked : heartbeat->revoked) {
      if (!mishaps_ || pick(2) == 0) forget(worker, revoked);  // others are completed all the same
    }
    if (!worker.leases.empty() && (!mishaps_ || pick(3) != 0)) finish_one(id, worker);
    if (worker.leases.size() < 2 * kLeasesPerCall) take(id, worker);
  }

  static void forget(Worker& worker, const v1::LeaseToken& token) {
    std::erase_if(worker.leases,
                  [&](const v1::LeaseToken& lease) { return lease.SerializeAsString() == token.SerializeAsString(); });
  }

  void take(const std::string& id, Worker& worker) {
    const auto decision = scheduler_->lease(
        {.worker = id, .max_units = 1 + pick(kLeasesPerCall), .loaded_scenes = {absl::StrCat("s", pick(2))}}, now_);
    ASSERT_TRUE(decision.ok());
    for (const std::string& job : decision->bound_jobs) models_[job].request.isa = scheduler_->job(job)->isa;
    std::set<std::pair<std::string, std::uint32_t>> seen;
    for (const v1::Lease& lease : decision->leases) {
      const v1::LeaseToken& token = lease.token();
      const Model& model = models_[token.job_id()];
      EXPECT_FALSE(model.done.contains(token.unit_index())) << "an acknowledged unit was given out again";
      EXPECT_FALSE(model.cancelled || model.failed);
      EXPECT_TRUE(seen.emplace(token.job_id(), token.unit_index()).second) << "one unit twice in one reply";
      for (const v1::LeaseToken& held : worker.leases) {
        // A lease that expired unnoticed may come again; within its time it may not.
        if (held.epoch() != token.epoch()) continue;
        EXPECT_FALSE(held.job_id() == token.job_id() && held.attempt() == token.attempt()) << "one attempt twice";
      }
      if (mishaps_ && pick(20) == 0) continue;  // the reply got lost
      worker.leases.push_back(token);
    }
  }

  void finish_one(const std::string& id, Worker& worker) {
    const std::size_t index = pick(worker.leases.size());
    const v1::LeaseToken token = worker.leases[index];
    Model& model = models_[token.job_id()];
    worker.leases.erase(worker.leases.begin() + static_cast<std::ptrdiff_t>(index));
    if (mishaps_ && pick(40) == 0) {
      const auto failed = scheduler_->fail(id, token, "no luck", pick(10) == 0, now_);
      if (failed.ok() && failed->job_failed) model.failed = true;
      return;
    }
    const bool wrong = mishaps_ && pick(30) == 0;
    const ResultFingerprint result = token.unit_index() + (wrong ? 1000 : 0);
    const auto decision = scheduler_->complete(id, token, result, now_);
    const auto known = model.done.find(token.unit_index());
    if (known != model.done.end()) {
      // The first result stays; the same one again is welcome, another one is a fault.
      ASSERT_EQ(decision.ok(), known->second == result) << decision.status();
      if (decision.ok()) {
        EXPECT_TRUE(decision->duplicate);
      }
      return;
    }
    if (model.cancelled || model.failed) {
      EXPECT_EQ(decision.status().code(), absl::StatusCode::kFailedPrecondition);
      return;
    }
    ASSERT_TRUE(decision.ok()) << decision.status();
    model.done[token.unit_index()] = result;
    EXPECT_EQ(decision->sequence, model.done.size());
    EXPECT_EQ(decision->job_done, model.done.size() == model.request.plan->unit_count());
  }

  void cancel() {
    auto& [id, model] = *std::next(models_.begin(), pick(models_.size()));
    const auto cancelled = scheduler_->cancel_job(id);
    ASSERT_TRUE(cancelled.ok());
    if (*cancelled) model.cancelled = true;
  }

  void restart() {
    scheduler_ = std::make_unique<Scheduler>(SchedulerOptions{.lease_timeout = kTimeout, .epoch = ++epoch_});
    for (auto& [id, model] : models_) {
      ASSERT_TRUE(scheduler_->add_job(model.request).ok());
      for (const auto& [unit, result] : model.done) ASSERT_TRUE(scheduler_->restore_done(id, unit, result).ok());
      // The service keeps the end of a job in its journal; here the same is reached by ending it again.
      if (model.cancelled || model.failed) {
        ASSERT_TRUE(scheduler_->cancel_job(id).ok());
      }
    }
  }

  void pass(Time time) {
    now_ += time;
    scheduler_->advance(now_);
  }

  bool ended(const Model& model) const {
    return model.cancelled || model.failed || model.done.size() == model.request.plan->unit_count();
  }

  bool all_ended() const {
    return std::all_of(models_.begin(), models_.end(), [&](const auto& entry) { return ended(entry.second); });
  }

  void check() {
    std::size_t leases = 0;
    for (const WorkerView& worker : scheduler_->workers()) leases += worker.leases;
    EXPECT_EQ(leases, scheduler_->leases_out());
    std::size_t units_leased = 0;
    for (const auto& [id, model] : models_) {
      const JobView view = scheduler_->job(id).value();
      EXPECT_EQ(view.units_done, model.done.size());
      EXPECT_LE(view.units_done + view.units_leased, view.units_total);
      if (ended(model)) {
        EXPECT_EQ(view.units_leased, 0u) << v1::JobState_Name(view.state);
      }
      units_leased += view.units_leased;
    }
    EXPECT_LE(units_leased, leases);
    EXPECT_LE(leases, units_leased * Scheduler::kMaxCopies);
  }

  std::mt19937 random_;
  bool mishaps_ = true;
  Time now_{0};
  std::uint64_t epoch_ = 1;
  int names_ = 0;
  std::unique_ptr<Scheduler> scheduler_ =
      std::make_unique<Scheduler>(SchedulerOptions{.lease_timeout = kTimeout, .epoch = 1});
  std::map<std::string, Model> models_;
  std::map<std::string, Worker> workers_;
};

TEST(Simulation, NothingIsLostAndEveryJobEnds) {
  for (std::uint32_t seed = 0; seed < 3000; ++seed) {
    SCOPED_TRACE(absl::StrCat("seed ", seed));
    Simulation(seed).run();
    if (testing::Test::HasFailure()) return;
  }
}

}  // namespace
}  // namespace tessera::server
