// Whose turn it is: by priority, then the user who has least work out, then that user's job with least work out.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>

namespace tessera::server {

/// Max-min fairness over what is out at this moment, in expected milliseconds of work, as fair schedulers of clusters
/// do it [Ghodsi2011]: a user with fewer jobs gets the same share as one with many, and a job of many short units the
/// same as one of few long ones. There is no memory: who asked for nothing for a while is owed nothing.
class TurnOrder {
 public:
  using JobNumber = std::uint64_t;

  /// One job as its turn comes up.
  struct Turn {
    JobNumber job = 0;
    std::int32_t priority = 0;
    std::int64_t user_load_ms = 0;  // of all of the user's jobs of this priority
    std::int64_t job_load_ms = 0;
  };

  void add(JobNumber job, std::int32_t priority, const std::string& user, std::int64_t load_ms);
  void remove(JobNumber job);
  bool contains(JobNumber job) const { return places_.contains(job); }
  /// Work was given to the job, or came back.
  void charge(JobNumber job, std::int64_t delta_ms);

  /// None for a job that takes no turns.
  std::optional<Turn> turn_of(JobNumber job) const;
  /// Whether the turn of `a` comes before that of `b`; both take turns.
  bool comes_before(JobNumber a, JobNumber b) const;

  /// Calls `visit` for every job, the next one due first, until it returns false.
  void for_each(const std::function<bool(const Turn&)>& visit) const;

 private:
  struct User {
    std::int64_t load_ms = 0;
    std::set<std::pair<std::int64_t, JobNumber>> jobs;  // by load, then age
  };
  struct Level {
    std::map<std::string, User> users;
    std::set<std::tuple<std::int64_t, JobNumber, std::string>>
        order;  // by load, then the user's least loaded job's age
  };
  struct Place {
    std::int32_t priority = 0;
    std::string user;
    std::int64_t load_ms = 0;
  };

  static std::tuple<std::int64_t, JobNumber, std::string> key(const std::string& name, const User& user);
  /// Changes one user of a level, keeping the order of users.
  void change_user(const Place& place, const std::function<void(User&)>& change);

  std::map<std::int32_t, Level, std::greater<>> levels_;  // highest priority first
  std::map<JobNumber, Place> places_;
};

}  // namespace tessera::server
