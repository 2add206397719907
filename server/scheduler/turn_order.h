// Whose turn it is: by priority, then the user who has had least of the farm lately, then that user's jobs.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "scheduler/lease_table.h"

namespace tessera::server {

/// Which of a user's jobs goes first.
enum class JobOrder {
  kFirstCome,  // the oldest; others where it has no units left
  kFair,       // the one that has had least: all advance together
};

/// Max-min fairness over the work that is out at this moment and what was done in the last kMemory, in
/// expected milliseconds, as fair schedulers of clusters do it [Ghodsi2011]: a user with fewer jobs gets the
/// same share as one with many, and short units count as much as long ones. Nothing else is remembered: who
/// asked for nothing for a while is owed nothing.
class TurnOrder {
 public:
  using JobNumber = std::uint64_t;

  static constexpr Time kMemory{10'000};

  explicit TurnOrder(JobOrder order) : order_(order) {}

  /// One job as its turn comes up.
  struct Turn {
    JobNumber job = 0;
    std::int32_t priority = 0;
    std::int64_t user_used_ms = 0;  // work of all of the user's jobs of this priority
    std::int64_t job_used_ms = 0;
  };

  /// `load_ms`: work of the job that is out.
  void add(JobNumber job, std::int32_t priority, const std::string& user, std::int64_t load_ms);
  void remove(JobNumber job);
  bool contains(JobNumber job) const { return places_.contains(job); }
  /// Work was given to the job, or came back.
  void charge(JobNumber job, std::int64_t delta_ms);
  /// Work of the job was done.
  void remember(JobNumber job, std::int64_t ms, Time now);
  /// Forgets what was done too long ago.
  void advance(Time now);

  enum class Next { kJob, kUser, kStop };
  /// Calls `visit` for every job, the next one due first, until it says stop; after kUser, the user's other
  /// jobs of this priority are left out.
  void for_each(const std::function<Next(const Turn&)>& visit) const;

 private:
  using UserKey = std::pair<std::int32_t, std::string>;  // priority, user
  // Sorted by what they had, where that counts, then by who has waited longest, then by age.
  using JobRank = std::tuple<std::int64_t, std::uint64_t, JobNumber>;
  using UserRank = std::tuple<std::int64_t, std::uint64_t, std::string>;
  struct User {
    std::int64_t load_ms = 0;
    std::uint64_t last_turn = 0;  // the turn when work was given to it, or it came
    std::set<JobRank> jobs;
  };
  struct Level {
    std::map<std::string, User> users;
    std::set<UserRank> order;
  };
  struct Place {
    UserKey user;
    std::int64_t load_ms = 0;
    std::uint64_t last_turn = 0;
  };
  struct Done {
    Time until{};
    JobNumber job = 0;
    UserKey user;
    std::int64_t ms = 0;
  };

  std::int64_t used_by(JobNumber job, const Place& place) const;
  JobRank rank_of(JobNumber job, const Place& place) const;
  UserRank rank_of(const UserKey& name, const User& user) const;
  /// Changes one user of a level, keeping the order of users.
  void change_user(const UserKey& name, const std::function<void(User&)>& change);
  void change_done(const Done& done, std::int64_t delta_ms);

  JobOrder order_;
  std::uint64_t turns_ = 0;
  std::map<std::int32_t, Level, std::greater<>> levels_;  // highest priority first
  std::map<JobNumber, Place> places_;
  // Latest completions, oldest first, and their sums.
  std::deque<Done> done_;
  absl::flat_hash_map<JobNumber, std::int64_t> done_by_job_;
  absl::flat_hash_map<UserKey, std::int64_t> done_by_user_;
};

}  // namespace tessera::server
