// Statistics of the runs of a benchmark, with their uncertainty.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bench/measure.h"

namespace tessera::client {

/// The geometric mean of positive numbers, and the ends of its 95 % interval by Student's t over their
/// logarithms; NaN ends when there is but one number.
struct Interval {
  double value = 0, low = 0, high = 0;

  bool has_ends() const { return low == low; }
};
Interval interval_of(const std::vector<double>& values);

/// "1.23 to 1.45", or a dash where it has no ends.
std::string ends_of(const Interval& interval);

/// An error against a noisy reference without the reference's own: their squares add up. As it was measured
/// where the reference would take more than half of it: then the reference is not good enough, and the error
/// is too large by at most a factor of two.
double without_noise(double measured, double noise);
/// Whether that happened to some run.
bool reference_too_noisy(const BenchSceneResult& scene);

/// 1 / (relMSE x CPU seconds).
double efficiency(const BenchRun& run, const ReferenceNoise& noise);
/// The same of means over blocks.
double block_efficiency(const BenchRun& run, const ReferenceNoise& noise);
using Efficiency = double(const BenchRun& run, const ReferenceNoise& noise);

/// The runs of one sample count, by seed.
std::vector<BenchRun> runs_of(const BenchVariantResult& variant, std::uint32_t spp);

/// The value of some property of the runs of one sample count.
template <class F>
Interval interval_over(const BenchVariantResult& variant, std::uint32_t spp, F property) {
  std::vector<double> values;
  for (const BenchRun& run : runs_of(variant, spp)) values.push_back(property(run));
  return interval_of(values);
}

/// Least squares of log MSE over log CPU time, over all runs; absent for one sample count.
struct Slope {
  double value = 0;
  double standard_error = 0;  // NaN for two runs
};
std::optional<Slope> slope_of(const BenchVariantResult& variant, const ReferenceNoise& noise);

/// How many times as efficient `b` is as `a`, seed by seed; over all sample counts (the mean of the
/// logarithms) where `spp` is absent. Both have the same sample counts and seeds.
Interval efficiency_ratio(const BenchVariantResult& a, const BenchVariantResult& b,
                          const ReferenceNoise& noise, std::optional<std::uint32_t> spp,
                          Efficiency& efficient = efficiency);

}  // namespace tessera::client
