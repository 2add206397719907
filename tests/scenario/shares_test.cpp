// How evenly equal jobs share a farm, and how long threads wait, when answers take a while: the scheduler with workers
// that ask for one unit ahead, as real ones do.
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <queue>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "absl/strings/str_cat.h"
#include "scenario/scenario_runner.h"

namespace tessera::server {
namespace {

struct Shares {
  int least = 0, most = 0;  // units of a job that were done when the first job was
  double waited = 0;        // part of the threads' time until then
};

/// Workers of one thread, and equal jobs of five users, each with a scene of its own.
class Farm {
 public:
  static constexpr Time kUnit{5000};   // half to one and a half times as long
  static constexpr Time kAnswer{500};  // up to twice as long
  static constexpr Time kPoll{250};

  Farm(int workers, int jobs, int units_of_job)
      : scheduler_({.lease_timeout = Time{3'600'000}, .audit_one_in = 0}),
        workers_(workers),
        done_(jobs),
        units_of_job_(units_of_job) {
    for (int job = 0; job < jobs; ++job) {
      EXPECT_TRUE(scheduler_
                      .add_job({.id = absl::StrCat(job),
                                .plan = row_of_tiles(units_of_job, 1),
                                .scene_digest = absl::StrCat("scene ", job),
                                .isa = "avx2",
                                .user = absl::StrCat("user ", job % 5),
                                .required_tags = {}})
                      .ok());
    }
    for (int worker = 0; worker < workers; ++worker) {
      const std::string id = absl::StrCat(worker);
      EXPECT_TRUE(scheduler_
                      .register_worker({.id = id,
                                        .name = id,
                                        .build = "",
                                        .isa = "avx2",
                                        .supported_isas = {"avx2"},
                                        .threads = 1,
                                        .host = id,
                                        .tags = {}},
                                       now_)
                      .ok());
      happen(Time(worker * 2000 / workers), Kind::kAsk, worker);
    }
  }

  /// Until all units of one job are done.
  Shares run() {
    while (*std::max_element(done_.begin(), done_.end()) < units_of_job_) {
      if (events_.empty()) {
        ADD_FAILURE() << "nobody does anything any more";
        return {};
      }
      const Event event = events_.top();
      events_.pop();
      now_ = event.at;
      step(event);
    }
    const auto [least, most] = std::minmax_element(done_.begin(), done_.end());
    const auto time = static_cast<double>(now_.count()) * static_cast<double>(workers_.size());
    return {.least = *least, .most = *most, .waited = static_cast<double>(waited_.count()) / time};
  }

 private:
  enum class Kind { kAsk, kRendered, kAnswered };
  struct Event {
    Time at{};
    Kind kind{};
    int worker = 0;
    v1::LeaseToken token;  // of what was rendered
    bool operator<(const Event& other) const { return at > other.at; }
  };
  struct Worker {
    std::deque<v1::LeaseToken> held;  // the first one is being rendered
    Time idle_since{0};
    std::vector<std::string> scenes;  // the two that it was given last
  };

  void happen(Time after, Kind kind, int worker, v1::LeaseToken token = {}) {
    events_.push({now_ + after, kind, worker, std::move(token)});
  }

  void step(const Event& event) {
    Worker& worker = workers_[event.worker];
    if (event.kind == Kind::kRendered) {
      const v1::LeaseToken token = worker.held.front();
      worker.held.pop_front();
      worker.idle_since = now_;
      if (!worker.held.empty()) begin(event.worker);
      happen(Time(random_() % (2 * kAnswer.count())), Kind::kAnswered, event.worker, token);
      return;
    }
    if (event.kind == Kind::kAnswered) {
      EXPECT_TRUE(
          scheduler_.complete(absl::StrCat(event.worker), event.token, {.fingerprint = 1, .cost = kUnit}, now_).ok());
      scheduler_.take_events();
      ++done_[std::stoi(event.token.job_id())];
    } else if (!worker.held.empty()) {
      return;
    }
    ask(event.worker);
    if (worker.held.empty()) happen(kPoll, Kind::kAsk, event.worker);
  }

  /// For what is being rendered, and one unit ahead.
  void ask(int number) {
    Worker& worker = workers_[number];
    if (worker.held.size() >= 2) return;
    const bool idle = worker.held.empty();
    const auto decision = scheduler_.lease({.worker = absl::StrCat(number),
                                            .max_units = static_cast<std::uint32_t>(2 - worker.held.size()),
                                            .loaded_scenes = worker.scenes},
                                           now_);
    ASSERT_TRUE(decision.ok());
    for (const v1::Lease& lease : decision->leases) {
      worker.held.push_back(lease.token());
      const std::string scene = absl::StrCat("scene ", lease.token().job_id());
      if (std::find(worker.scenes.begin(), worker.scenes.end(), scene) != worker.scenes.end()) continue;
      worker.scenes.push_back(scene);
      if (worker.scenes.size() > 2) worker.scenes.erase(worker.scenes.begin());
    }
    if (idle && !worker.held.empty()) begin(number);
  }

  void begin(int number) {
    waited_ += now_ - workers_[number].idle_since;
    happen(kUnit / 2 + Time(random_() % kUnit.count()), Kind::kRendered, number);
  }

  Scheduler scheduler_;
  std::vector<Worker> workers_;
  std::vector<int> done_;  // units of each job
  int units_of_job_;
  Time now_{0}, waited_{0};
  std::priority_queue<Event> events_;
  std::minstd_rand random_{1};
};

void expect_even(const Shares& shares, double least) {
  std::printf("%d to %d units of each job; threads waited for %.1f %% of their time\n", shares.least, shares.most,
              100 * shares.waited);
  EXPECT_GE(shares.least, least * shares.most);
  EXPECT_LE(shares.waited, 0.03);
}

TEST(Shares, ManyEqualJobsAdvanceTogetherAndThreadsHardlyWait) {
  expect_even(Farm(/*workers=*/500, /*jobs=*/50, /*units_of_job=*/160).run(), 0.85);
}

TEST(Shares, FewLongJobsAdvanceTogetherAndThreadsHardlyWait) {
  expect_even(Farm(/*workers=*/500, /*jobs=*/10, /*units_of_job=*/800).run(), 0.97);
}

}  // namespace
}  // namespace tessera::server
