#include "pilot/missing_light.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "image/metrics.h"
#include "pilot/mean.h"

namespace tessera::client {
namespace {

constexpr std::uint32_t kGrids[] = {1, 4};    // blocks across and down
constexpr std::uint32_t kLeastBlockSide = 2;  // pixels
constexpr double kSignificance = 1e-2;        // level of all tests together

/// The mean area of the passes' disks, relative to the first's.
double disk_area(const PilotImage& image) {
  double sum = 0;
  for (std::uint32_t pass = image.sample_begin; pass < image.sample_end; ++pass)
    sum += std::pow(pass + 1.0, -1.0 / 3.0);
  return sum / image.samples();
}

/// The value at x = 0 of the line of least squares; the mean where all x are equal.
Mean intercept_of(std::span<const double> x, std::span<const double> y) {
  const double n = static_cast<double>(y.size());
  const Mean mean_x = mean_of(x), mean_y = mean_of(y);
  const double xx = mean_x.variance * n * (n - 1);
  if (y.size() < 4 || !(xx > 1e-6 * mean_x.value * mean_x.value)) return mean_y;
  double xy = 0, rest = 0;
  for (std::size_t i = 0; i < y.size(); ++i) xy += (x[i] - mean_x.value) * (y[i] - mean_y.value);
  const double slope = xy / xx;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const double off = y[i] - mean_y.value - slope * (x[i] - mean_x.value);
    rest += off * off;
  }
  const double variance = rest / (n - 2);
  return {mean_y.value - slope * mean_x.value, variance * (1 / n + mean_x.value * mean_x.value / xx), n - 2};
}

/// The degrees of freedom of a difference of means [Welch 1947].
double dof_of(const Mean& low, const Mean& high) {
  const double variance = low.variance + high.variance;
  return variance * variance /
         (low.variance * low.variance / low.dof + high.variance * high.variance / high.dof);
}

/// The probability that a difference of means is as large by chance, where there is none.
double p_value(const Mean& low, const Mean& high) {
  const double variance = low.variance + high.variance, difference = high.value - low.value;
  if (difference <= 0) return 1;
  if (variance <= 0) return 0;
  const double dof = dof_of(low, high);
  return 0.5 * student_t_p_value(difference / std::sqrt(variance), dof);
}

/// Squares of a grid over the frame.
class Blocks {
 public:
  Blocks(const PilotFrame& frame, std::uint32_t across)
      : frame_(frame), across_(across), pixels_(std::size_t{across} * across) {
    for (std::size_t i = 0; i < frame.pixels(); ++i) ++pixels_[block_of(i)];
  }

  std::size_t count() const { return pixels_.size(); }
  double pixels(std::size_t block) const { return static_cast<double>(pixels_[block]); }

  /// The means of a candidate's pictures over each block; at radius zero if `extrapolated` is set.
  std::vector<Mean> means(const PilotCandidate& candidate, std::span<const double> norms,
                          bool extrapolated) const {
    std::vector<std::vector<double>> y(count(), std::vector<double>(candidate.images.size()));
    std::vector<double> x(candidate.images.size());
    for (std::size_t k = 0; k < candidate.images.size(); ++k) {
      const PilotImage& image = candidate.images[k];
      x[k] = disk_area(image);
      for (std::size_t i = 0; i < image.values.size(); ++i) {
        const std::size_t block = block_of(i % frame_.pixels());
        y[block][k] += image.values[i] / norms[i] / (3 * pixels(block));
      }
    }
    std::vector<Mean> means;
    for (const std::vector<double>& of_block : y)
      means.push_back(extrapolated ? intercept_of(x, of_block) : mean_of(of_block));
    return means;
  }

 private:
  std::size_t block_of(std::size_t pixel) const {
    const std::size_t x = pixel % frame_.width(), y = pixel / frame_.width();
    return y * across_ / frame_.height() * across_ + x * across_ / frame_.width();
  }

  const PilotFrame& frame_;
  const std::size_t across_;
  std::vector<std::size_t> pixels_;
};

/// Whoever sees the most of the light that a block lacks.
struct Brightest {
  double difference = 0;
  std::size_t candidate = 0;
};

}  // namespace

std::vector<MissingLight> find_missing_light(std::span<const PilotCandidate> candidates,
                                             const PilotFrame& frame, std::uint32_t spp,
                                             std::span<const double> norms) {
  std::vector<MissingLight> missing(candidates.size());
  std::vector<Blocks> grids;
  std::size_t tests = 0;
  for (const std::uint32_t across : kGrids) {
    if (across > 1 && std::min(frame.width(), frame.height()) < across * kLeastBlockSide) continue;
    grids.emplace_back(frame, across);
    tests += grids.back().count() * candidates.size() * (candidates.size() - 1);
  }
  for (const Blocks& blocks : grids) {
    std::vector<std::vector<Mean>> means;
    for (const PilotCandidate& candidate : candidates)
      means.push_back(blocks.means(candidate, norms, candidate.consistent));
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      if (candidates[c].consistent) continue;
      const double samples =
          static_cast<double>(candidates[c].images.size()) * candidates[c].images.front().samples();
      double error = 0, worst = 0;
      std::size_t seen_by = 0;
      for (std::size_t block = 0; block < blocks.count(); ++block) {
        Brightest most;
        for (std::size_t other = 0; other < candidates.size(); ++other) {
          const Mean &own = means[c][block], &theirs = means[other][block];
          if (other == c || theirs.value - own.value <= most.difference) continue;
          if (p_value(own, theirs) * static_cast<double>(tests) < kSignificance)
            most = {theirs.value - own.value, other};
        }
        const double found_in = blocks.pixels(block) * samples;
        const double share = blocks.pixels(block) / static_cast<double>(frame.pixels());
        const double lacking =
            share * most.difference * most.difference * std::max(1.0, found_in / static_cast<double>(spp));
        error += lacking;
        if (lacking > worst) worst = lacking, seen_by = most.candidate;
      }
      if (error > missing[c].error) missing[c] = {error, candidates[seen_by].name};
    }
  }
  return missing;
}

double excess_light(const PilotCandidate& broad, const PilotCandidate& narrow, const PilotFrame& frame,
                    std::span<const double> norms) {
  const bool is_small = std::min(frame.width(), frame.height()) < kGrids[1] * kLeastBlockSide;
  const Blocks blocks(frame, kGrids[is_small ? 0 : 1]);
  const std::vector<Mean> high = blocks.means(broad, norms, false), low = blocks.means(narrow, norms, false);
  double sum = 0, count = 0;
  for (std::size_t block = 0; block < blocks.count(); ++block) {
    const double variance = low[block].variance + high[block].variance;
    const double dof = variance > 0 ? dof_of(low[block], high[block]) : 0;
    if (dof <= 2) continue;
    sum += (high[block].value - low[block].value) / std::sqrt(variance * dof / (dof - 2));
    ++count;
  }
  return count > 0 ? sum / std::sqrt(count) : 0;
}

}  // namespace tessera::client
