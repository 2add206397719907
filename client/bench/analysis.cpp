#include "bench/analysis.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <numeric>

#include "absl/strings/str_format.h"
#include "image/metrics.h"

namespace tessera::client {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace

Interval interval_of(const std::vector<double>& values) {
  if (values.empty()) return {kNan, kNan, kNan};
  std::vector<double> logs;
  for (const double value : values) logs.push_back(std::log(value));
  const double mean = mean_of(logs), n = static_cast<double>(logs.size());
  if (values.size() == 1) return {values.front(), kNan, kNan};
  double squares = 0;
  for (const double log : logs) squares += (log - mean) * (log - mean);
  const double half = student_t_quantile(0.05, n - 1) * std::sqrt(squares / (n - 1) / n);
  return {std::exp(mean), std::exp(mean - half), std::exp(mean + half)};
}

std::string ends_of(const Interval& interval) {
  return interval.has_ends() ? absl::StrFormat("%.4g to %.4g", interval.low, interval.high) : "-";
}

double without_noise(double measured, double noise) {
  return noise > measured / 2 ? measured : measured - noise;
}

bool reference_too_noisy(const BenchSceneResult& scene) {
  return std::ranges::any_of(scene.variants, [&](const BenchVariantResult& variant) {
    return std::ranges::any_of(variant.runs, [&](const BenchRun& run) {
      return scene.noise.mse > run.mse / 2 || scene.noise.relmse > run.relmse / 2;
    });
  });
}

double efficiency(const BenchRun& run, const ReferenceNoise& noise) {
  return 1 / (without_noise(run.relmse, noise.relmse) * run.cost.cpu_seconds);
}

double block_efficiency(const BenchRun& run, const ReferenceNoise& noise) {
  return 1 / (without_noise(run.relmse_block, noise.relmse_block) * run.cost.cpu_seconds);
}

std::vector<BenchRun> runs_of(const BenchVariantResult& variant, std::uint32_t spp) {
  std::vector<BenchRun> runs;
  for (const BenchRun& run : variant.runs) {
    if (run.spp == spp) runs.push_back(run);
  }
  return runs;
}

std::optional<Slope> slope_of(const BenchVariantResult& variant, const ReferenceNoise& noise) {
  std::vector<double> x, y;
  for (const BenchRun& run : variant.runs) {
    x.push_back(std::log(run.cost.cpu_seconds));
    y.push_back(std::log(without_noise(run.mse, noise.mse)));
  }
  if (variant.runs.empty() || variant.runs.front().spp == variant.runs.back().spp) return std::nullopt;
  const double mean_x = mean_of(x), mean_y = mean_of(y);
  double xx = 0, xy = 0, rest = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mean_x) * (x[i] - mean_x);
    xy += (x[i] - mean_x) * (y[i] - mean_y);
  }
  const double slope = xy / xx;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double off = y[i] - mean_y - slope * (x[i] - mean_x);
    rest += off * off;
  }
  const double dof = static_cast<double>(x.size()) - 2;
  return Slope{slope, dof > 0 ? std::sqrt(rest / dof / xx) : kNan};
}

Interval efficiency_ratio(const BenchVariantResult& a, const BenchVariantResult& b,
                          const ReferenceNoise& noise, std::optional<std::uint32_t> spp,
                          Efficiency& efficient) {
  std::map<std::uint64_t, std::vector<double>> logs_by_seed;
  for (std::size_t i = 0; i < std::min(a.runs.size(), b.runs.size()); ++i) {
    if (spp && a.runs[i].spp != *spp) continue;
    logs_by_seed[a.runs[i].seed_offset].push_back(
        std::log(efficient(b.runs[i], noise) / efficient(a.runs[i], noise)));
  }
  std::vector<double> ratios;
  for (const auto& [seed, of_seed] : logs_by_seed) ratios.push_back(std::exp(mean_of(of_seed)));
  return interval_of(ratios);
}

}  // namespace tessera::client
