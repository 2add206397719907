// A farm on which nothing goes wrong: the real scheduler, machines that take their time, and answers that
// take theirs. Workers ask for units ahead, as real ones do. For what a farm gets done, and who gets it.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <queue>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "scheduler/scheduler.h"

namespace tessera::server {

struct SteadyFarmOptions {
  struct Machine {
    std::uint32_t threads = 1;
    double slowness = 1;
    Time joins{0};
    /// From `changes` on it is this slow.
    Time changes{std::chrono::hours{1000}};
    double then = 1;
  };
  struct Work {
    std::string user;
    std::string scene;
    std::uint32_t units = 1;
    std::uint32_t ranges = 1;  // ranges per tile: units of one tile cost the same, and may be leased as one
    double median_ms = 1000;   // time of a unit on a usual thread
    Time submitted{0};
  };
  std::vector<Machine> machines = {};
  std::vector<Work> jobs = {};
  std::uint64_t seed = 1;

  /// Standard deviation of the logarithm of what units cost, and correlation of neighbours.
  double spread = 0, correlation = 0;
  /// The same of the cost of one ray; none: workers do not say how many there were.
  std::optional<double> ray_spread = {};
  Time answer{5};  // up to twice as long
  SchedulerOptions scheduler{.lease_timeout = Time{std::chrono::hours{100}}, .audit_one_in = 0};
};

class SteadyFarm {
 public:
  explicit SteadyFarm(SteadyFarmOptions options);

  /// Until `enough` says so, which is asked after each result, or all is done.
  void run(const std::function<bool()>& enough = [] { return false; });

  Time now() const { return std::chrono::duration_cast<Time>(now_); }
  /// Units of each job that are done.
  const std::vector<std::uint32_t>& done() const { return done_; }
  /// Results of each job, which may be of several units.
  const std::vector<std::uint32_t>& results() const { return results_; }
  /// Time on a usual thread of the longest lease that was given out after the first eight results of its job.
  Time longest_lease() const { return std::chrono::duration_cast<Time>(longest_lease_); }
  /// When the job's last unit was done.
  Time finished(std::size_t job) const { return std::chrono::duration_cast<Time>(finished_[job]); }
  /// When the job's first unit was given out, counted from its submission; none before that.
  std::optional<Time> first_lease_after(std::size_t job) const { return first_lease_[job]; }
  /// Part of the threads' time until now that they had nothing to do, and the same while units were waiting.
  double idle() const { return idle_ / thread_time_; }
  double idle_while_units_wait() const { return idle_in_vain_ / thread_time_; }
  /// Slowness of a machine as the scheduler sees it.
  double slowness(std::size_t machine) const;
  bool is_done() const;

 private:
  using Instant = std::chrono::microseconds;  // short units take few milliseconds
  enum class Kind { kSubmit, kJoin, kAsk, kRendered, kAnswered };
  struct Event {
    Instant at{};
    std::uint64_t order = 0;
    Kind kind{};
    std::size_t which = 0;  // machine or job
    v1::LeaseToken token{};
    Instant cost{};
    bool operator<(const Event& other) const {
      return std::pair{at, order} > std::pair{other.at, other.order};
    }
  };
  struct Worker {
    bool joined = false;
    std::deque<v1::LeaseToken> queue;
    std::uint32_t running = 0;
    std::vector<std::string> scenes;  // the two that it was given last
    bool asks_again = false;
  };

  void happen(Instant after, Event event);
  void step(const Event& event);
  void submit(std::size_t job);
  void ask(std::size_t machine);
  void begin(std::size_t machine);
  void count_idle(Instant until);
  UnitRun units_of(const v1::LeaseToken& token) const;
  double slowness_now(std::size_t machine) const;

  SteadyFarmOptions options_;
  Scheduler scheduler_;
  std::vector<Worker> workers_;
  std::vector<std::vector<double>> costs_, rays_;  // cost in ms on a usual thread, and rays, of each unit
  std::vector<std::uint32_t> done_, results_;
  std::vector<std::shared_ptr<const WorkPlan>> plans_;
  std::vector<std::vector<bool>> waits_;  // units that nobody was given
  std::uint64_t waiting_ = 0;
  std::vector<Instant> finished_;
  std::vector<std::optional<Time>> first_lease_;
  Instant now_{0}, longest_lease_{0};
  double idle_ = 0, idle_in_vain_ = 0, thread_time_ = 0;  // thread-microseconds
  std::uint64_t order_ = 0;
  std::priority_queue<Event> events_;
  std::mt19937_64 random_;
};

}  // namespace tessera::server
