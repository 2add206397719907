// Whose arithmetic a job is rendered in: results of two classes differ in rounding [docs/decisions/0019].
#pragma once

#include <string>
#include <vector>

#include "scheduler/farm_state.h"
#include "scheduler/policy/trust.h"

namespace tessera::server {

class Classes {
 public:
  static constexpr std::size_t kMaxClosedJobs = 8;
  static constexpr int kMostSettles = 8;  // SchedulerOptions::settle, whoever still comes

  Classes(FarmState& state, const Trust& trust) : state_(state), trust_(trust) {}

  /// Takes the worker into the tally while it may be given units, and out of it otherwise.
  void count(FarmWorker& worker);
  /// Whether a worker that may be given units computes in this class.
  bool has_class(const std::string& name) const;
  /// The class in which the worker renders for the job; null when it may not, for its arithmetic.
  const std::string* class_for(const FarmWorker& worker, const FarmJob& job) const;
  const std::string& class_of_result(const FarmJob& job, const AcceptedResult& result) const;
  /// Two identities have the same result in this class.
  void confirm(const std::string& name, const std::string& identity, const std::string& other);
  /// From now on so many of the worker's threads count.
  void count_threads(FarmWorker& worker, std::uint32_t threads);
  /// Whether the job is bound to a class of which no worker is left, and another class could take it.
  bool is_forsaken(const FarmJob& job) const;
  /// The job, none of whose results count, is bound to no class any more.
  void unbind(FarmJob& job);
  /// Whether the job's class had better be chosen a moment later.
  bool settling(const FarmJob& job, Time now) const;
  /// From now on the job is rendered in this class, unless it is for all.
  void bind(FarmJob& job, const std::string& name);
  /// The host's results from this number on are of the class.
  void note(FarmJob& job, const std::string& host, std::uint32_t sequence, const std::string& name);
  /// Which workers may not work on an open job for their arithmetic; empty when all may.
  std::string left_out(const FarmJob& job) const;
  /// Open jobs of whatever priority that the worker may not work on for its arithmetic: kMaxClosedJobs.
  std::vector<std::string> closed_jobs(const FarmWorker& worker) const;

 private:
  const std::string& class_of(const FarmJob& job) const;

  FarmState& state_;
  const Trust& trust_;
};

}  // namespace tessera::server
