#include "scheduler/worker_pace.h"

#include <algorithm>
#include <cmath>

namespace tessera::server {
namespace {

// Standard deviations. Of a million results of equal workers, a handful lie beyond the one, and one in twenty
// beyond the other: enough to keep what is likely to be the worker's from what is taken for the job's.
constexpr double kBeyondDoubt = 4.5, kLikely = 2;
constexpr double kStandardError = 1.2533;  // of a median, relative to that of a mean: sqrt(pi / 2)

// A pace changes: a standard deviation of 2 % from one result to the next keeps the latest 15 to 50 in mind.
constexpr double kDrift = 0.0005;

// A host that is suddenly slow, or fast again: the mean of about four deviations, each counted as four
// standard deviations at most, which is beyond two only once in a million where nothing has changed.
constexpr double kSurpriseGain = 0.25, kMostSurprise = 4, kSurprising = 2;

constexpr double kLongestMemory = 256;                    // results, of a job's spread
constexpr double kLeastSpread = 0.01, kMostSpread = 8.0;  // a tenth, and a factor of 17
constexpr double kMostCorrelation = 0.98;

// A worker says itself how long it took and how much it did. Beyond a factor of 30 from the others its word
// counts no more, so that no claim takes the farm from anybody.
constexpr double kMostDifference = 3.4;

/// How far the pace is from the usual one; 0 where that is no more than so many standard deviations.
double difference(const WorkerPace& pace, const UsualPace& usual, double deviations) {
  const double seen = pace.log_time - usual.log_time;
  const double doubt = deviations * deviations * (pace.variance + usual.variance);
  return seen * seen <= doubt ? 0 : seen - doubt / seen;
}

/// One step of a Kalman filter whose state is the pace: a result was so far from what was expected, with so
/// much variance of its own.
void learn_pace(WorkerPace& worker, double deviation, double variance) {
  const double expected = std::sqrt(worker.variance + variance);
  const double gain = worker.variance / (worker.variance + variance);
  worker.log_time += gain * deviation;
  worker.variance = std::min((1 - gain) * worker.variance + kDrift, WorkerPace::kUnknownVariance);

  const double surprise = std::clamp(deviation / expected, -kMostSurprise, kMostSurprise);
  worker.surprise += kSurpriseGain * (surprise - worker.surprise);
  if (std::abs(worker.surprise) <= kSurprising) return;
  worker.variance = WorkerPace::kUnknownVariance;
  worker.surprise = 0;
}

}  // namespace

UsualPace usual_pace(const std::vector<const WorkerPace*>& workers) {
  if (workers.empty()) return {};
  std::vector<double> times;
  double variance = 0;
  for (const WorkerPace* const worker : workers) {
    times.push_back(worker->log_time);
    variance += worker->variance;
  }
  const auto count = static_cast<double>(times.size());
  // The lower median of an even number: of two workers, the faster says what is usual.
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>((times.size() - 1) / 2);
  std::nth_element(times.begin(), middle, times.end());
  const double mean = variance / count;
  return {.log_time = *middle, .variance = std::min(mean, kStandardError * kStandardError * mean / count)};
}

double slowness_of(const WorkerPace& pace, const UsualPace& usual) {
  return std::exp(std::clamp(difference(pace, usual, kBeyondDoubt), -kMostDifference, kMostDifference));
}

/// Variance of one unit, as if successive ones were independent: what a mean of many shows of it.
double JobPace::noise() const {
  const double correlation = std::clamp(1 - step_ / spread_, 0.0, kMostCorrelation);
  return spread_ * (1 + correlation) / (1 - correlation);
}

void JobPace::learn_spread(WorkerPace& worker, double log_cost, double usual_log_cost) {
  if (results_ == 0) mean_ = usual_log_cost;
  results_ = std::min(results_ + 1, kLongestMemory);
  spread_weight_ = std::min(spread_weight_ + 1, kLongestMemory);
  const double deviation = usual_log_cost - mean_;
  mean_ += deviation / results_;
  spread_ += (std::min(deviation * deviation, kMostSpread) - spread_) / spread_weight_;
  spread_ = std::max(spread_, kLeastSpread);
  if (worker.last_job == job_) {
    step_weight_ = std::min(step_weight_ + 1, kLongestMemory);
    const double step = log_cost - worker.last_log_cost;
    step_ += (std::min(step * step / 2, kMostSpread) - step_) / step_weight_;
    step_ = std::max(step_, kLeastSpread);
  }
  worker.last_job = job_;
  worker.last_log_cost = log_cost;
}

/// Median of what the latest results cost; there is one.
double JobPace::level() const {
  std::vector<double> costs;
  for (const Result& result : latest_) costs.push_back(result.usual_log_cost);
  std::sort(costs.begin(), costs.end());
  return (costs[(costs.size() - 1) / 2] + costs[costs.size() / 2]) / 2;
}

void JobPace::compare(WorkerPace& worker, const UsualPace& usual, double log_cost) {
  if (!latest_.empty()) log_cost = std::clamp(log_cost, level() - kMostDifference, level() + kMostDifference);
  const double usual_log_cost = log_cost - difference(worker, usual, kLikely);
  learn_spread(worker, log_cost, usual_log_cost);
  const bool alone = std::all_of(latest_.begin(), latest_.end(),
                                 [&](const Result& result) { return result.worker == worker.worker; });
  if (!alone) {
    const double variance = (1 + 1 / static_cast<double>(latest_.size())) * noise();
    learn_pace(worker, log_cost - level() - worker.log_time, variance);
  }
  if (latest_.size() == kMostComparedResults) latest_.erase(latest_.begin());
  latest_.push_back({.worker = worker.worker, .usual_log_cost = usual_log_cost});
}

}  // namespace tessera::server
