#include "pilot/estimate.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>
#include <random>
#include <span>
#include <thread>
#include <vector>

#include "pilot/mean.h"

namespace tessera::client {
namespace {

/// The sum over `parts` parts, of which these are some, and its standard error.
struct Total {
  double value = 0, error = 0;
};

Total total_of(std::span<const PartCost> costs, const SurveyPlan& plan, double PartCost::*figure) {
  std::vector<double> values;
  for (const PartCost& cost : costs) values.push_back(cost.*figure);
  const double all = static_cast<double>(plan.parts);
  if (values.size() < 2) return {all * values.front(), 0};
  const Mean mean = mean_of(values);
  const double left = plan.whole ? 1 - static_cast<double>(values.size()) / all : 1;
  return {all * mean.value, all * std::sqrt(mean.variance * left)};
}

JobEstimate estimate_by(std::span<const PartCost> costs, const SurveyPlan& plan) {
  const Total cpu = total_of(costs, plan, &PartCost::cpu_seconds),
              samples = total_of(costs, plan, &PartCost::samples);
  return {.cpu_seconds = cpu.value,
          .cpu_error = cpu.error,
          .samples = samples.value,
          .samples_error = samples.error,
          .capped = total_of(costs, plan, &PartCost::capped).value,
          .parts = costs.size()};
}

/// The survey while it is made. Which parts count depends on their order alone, and how many of them on what
/// those before had cost: not on which of them were quicker.
class Survey {
 public:
  Survey(const SurveyPlan& plan, const std::function<absl::StatusOr<PartCost>(std::size_t)>& measure,
         std::stop_token stop)
      : plan_(plan), measure_(measure), stop_(std::move(stop)), order_(plan.parts) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::ranges::shuffle(order_, std::mt19937_64(plan.seed));
  }

  absl::StatusOr<JobEstimate> run() {
    while (!is_enough()) {
      const std::size_t batch =
          std::max<std::size_t>(costs_.size() < kFirstParts ? kFirstParts : costs_.size() / 2, 1);
      if (absl::Status status = render_until(std::min(costs_.size() + batch, plan_.parts)); !status.ok())
        return status;
    }
    JobEstimate estimate = estimate_by(costs_, plan_);
    estimate.survey_seconds = spent_;
    return estimate;
  }

 private:
  bool is_enough() const {
    if (costs_.size() == plan_.parts) return true;
    if (costs_.size() < std::min(kFirstParts, plan_.parts)) return false;
    if (spent_ >= plan_.cpu_seconds) return true;
    const JobEstimate so_far = estimate_by(costs_, plan_);
    return so_far.cpu_error <= plan_.wanted_error * so_far.cpu_seconds;
  }

  absl::Status render_until(std::size_t end) {
    std::size_t next = costs_.size();
    costs_.resize(end);
    std::mutex mutex;
    absl::Status status;
    const auto work = [&](bool warm) {
      while (true) {
        std::size_t own;
        {
          const std::lock_guard lock{mutex};
          if (next == end || !status.ok()) return;
          own = next++;
        }
        absl::StatusOr<PartCost> cost =
            stop_.stop_requested() ? absl::CancelledError("interrupted") : measure_(order_[own]);
        const double first = cost.ok() && !warm ? cost->spent : 0;
        if (cost.ok() && !warm) cost = measure_(order_[own]);
        warm = true;
        const std::lock_guard lock{mutex};
        status.Update(cost.status());
        if (!cost.ok()) return;
        costs_[own] = *cost;
        spent_ += first + cost->spent;
      }
    };
    {
      std::vector<std::jthread> helpers;
      for (int i = 1; i < plan_.threads; ++i) helpers.emplace_back(work, is_warm_);
      work(is_warm_);
    }
    is_warm_ = true;
    return status;
  }

  const SurveyPlan& plan_;
  const std::function<absl::StatusOr<PartCost>(std::size_t)>& measure_;
  const std::stop_token stop_;
  std::vector<std::size_t> order_;
  std::vector<PartCost> costs_;
  double spent_ = 0;
  bool is_warm_ = false;
};

}  // namespace

absl::StatusOr<JobEstimate> survey(const SurveyPlan& plan,
                                   const std::function<absl::StatusOr<PartCost>(std::size_t)>& measure,
                                   std::stop_token stop) {
  return Survey(plan, measure, std::move(stop)).run();
}

}  // namespace tessera::client
