// The cost of a job, by a survey: some of its parts, chosen at random, are rendered as the job would.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <stop_token>

#include "absl/status/statusor.h"

namespace tessera::client {

/// One part of a job, rendered.
struct PartCost {
  double cpu_seconds = 0;  // time for all of the part's samples
  double samples = 0;      // samples of all of its pixels together
  double capped = 0;       // pixels that take all samples they may
  double spent = 0;        // CPU seconds of finding out
};

struct SurveyPlan {
  std::size_t parts = 1;       // parts of the job
  bool whole = true;           // parts are rendered with all of their samples
  double wanted_error = 0.05;  // standard error of the cost, as a share of it, at which the survey ends
  double cpu_seconds = 60;     // upper bound, but for the first parts
  int threads = 1;
  std::uint64_t seed = 0;  // decides which parts are chosen
};

/// The parts of a survey before anything is told of its error.
inline constexpr std::size_t kFirstParts = 24;

/// Costs of the whole job. Standard errors are 0 where every part was rendered with all of its samples.
struct JobEstimate {
  double cpu_seconds = 0, cpu_error = 0;
  double samples = 0, samples_error = 0;
  double capped = 0;
  std::size_t parts = 0;      // rendered parts
  double survey_seconds = 0;  // CPU time of that
};

/// Chooses parts without replacement, each as likely as the others, so that sums over the job are estimated
/// without bias, and the error by the spread between parts with the correction for a finite population
/// [Cochran1977, section 2.6], unless parts were not rendered as a whole. `measure` renders a part (a number
/// below `parts`), from several threads at once; its first call on each thread is made twice, for the first
/// finds cold caches. Errors of `measure`; Cancelled when stopped.
absl::StatusOr<JobEstimate> survey(const SurveyPlan& plan,
                                   const std::function<absl::StatusOr<PartCost>(std::size_t)>& measure,
                                   std::stop_token stop);

}  // namespace tessera::client
