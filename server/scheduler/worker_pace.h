// How fast workers are, relative to one another. Only results of different workers for the same job are
// compared, so nothing that a job's units cost, however uneven they are, can pass for a property of all
// workers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tessera::server {

/// Estimate of one worker's time for a unit, as a natural logarithm. Ratings of players are kept in the same
/// way [Glickman1999]: one says something only in comparison with another, and has a variance.
struct WorkerPace {
  /// Variance before anything is known: mostly within e times the usual.
  static constexpr double kUnknownVariance = 1;

  std::uint64_t worker = 0;  // a number that no other worker has
  double log_time = 0;
  double variance = kUnknownVariance;

  // Its latest result: of which job (none: no job has this number), and what it cost.
  std::uint64_t last_job = ~std::uint64_t{0};
  double last_log_cost = 0;
  double surprise = 0;  // moving average of deviations from what was expected, in standard deviations
};

/// The pace by which all others are judged: the median. Those about whom nothing is known yet count as usual.
struct UsualPace {
  double log_time = 0;
  double variance = 0;
};
UsualPace usual_pace(const std::vector<const WorkerPace*>& workers);

/// How long the worker's units take, as a multiple of the usual time: 1 until results show beyond doubt that
/// it is not (a non-negative garrote [Breiman1995] at kDoubt standard deviations).
double slowness_of(const WorkerPace& pace, const UsualPace& usual);

/// The latest results of one job, which the next one is compared with.
class JobPace {
 public:
  static constexpr std::size_t kMostComparedResults = 8;

  explicit JobPace(std::uint64_t job) : job_(job) {}

  /// Takes in a result: `log_cost` is the logarithm of what it took on one thread, for each piece of work in
  /// it where that is known. Says nothing of a worker that is alone on the job.
  void compare(WorkerPace& worker, const UsualPace& usual, double log_cost);

 private:
  struct Result {
    std::uint64_t worker = 0;
    double usual_log_cost = 0;  // cost on a usual worker
  };

  void learn_spread(WorkerPace& worker, double log_cost, double usual_log_cost);
  double noise() const;
  double level() const;

  std::uint64_t job_;
  std::vector<Result> latest_;  // the oldest first

  // Costs of this job's units on workers of one pace: mean, variance, and half the mean square difference
  // of a worker's successive ones [vonNeumann1941]. Neighbours cost much the same, so ten of them say less
  // than ten from all over the picture.
  static constexpr double kFirstSpread =
      1.3;  // costs over two decades: a standard deviation is a factor of three
  static constexpr double kFirstWeight = 8;
  double results_ = 0;  // number of results in the mean
  double mean_ = 0, spread_ = kFirstSpread, spread_weight_ = kFirstWeight;
  double step_ = kFirstSpread, step_weight_ = kFirstWeight;
};

}  // namespace tessera::server
