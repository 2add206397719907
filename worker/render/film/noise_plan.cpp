#include "render/film/noise_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "render/film/filter_value.h"
#include "wire/limits.h"

namespace tessera::render {
namespace {

/// Numbers of blocks, as those of a pilot.
using Plane = std::vector<double>;

/// Means over neighbours, weighted 1 2 1 each way; the blocks at borders weigh what is beyond them.
Plane smoothed(const FilmRect& blocks, Plane plane, int times) {
  const std::size_t width = blocks.width(), height = blocks.y1 - blocks.y0;
  Plane next(plane.size());
  const auto pass = [&](std::size_t lines, std::size_t line, std::size_t size, std::size_t step) {
    for (std::size_t l = 0; l < lines; ++l) {
      for (std::size_t i = 0; i < size; ++i) {
        const std::size_t at = l * line + i * step;
        const double before = plane[i > 0 ? at - step : at], after = plane[i + 1 < size ? at + step : at];
        next[at] = 0.25 * (before + 2 * plane[at] + after);
      }
    }
    plane.swap(next);
  };
  for (int i = 0; i < times; ++i) {
    pass(height, width, width, 1);
    pass(width, 1, height, width);
  }
  return plane;
}

double sum_of(const Plane& plane) {
  double sum = 0;
  for (const double value : plane) sum += value;
  return sum;
}

/// How counts follow from errors that are known but roughly.
struct Rule {
  bool gentle = false;  // the root of what would be best if errors were known
  double least = 1;     // added to all, as a share of the mean
};
constexpr Rule kRules[] = {{false, 0.05}, {false, 0.2}, {false, 0.8}, {true, 0.05}, {true, 0.2}, {true, 0.8}};
/// Passes of smoothed() before each trial of the rules: 1, 2, 4 and 8 in all.
constexpr int kSmoothing[] = {1, 1, 2, 4};
/// Least gain that is reason to leave equal counts, as a share of the work for the same error: rays are not
/// all the time that samples take, and errors fall faster than by 1 / n where there is little noise.
constexpr double kLeastGain = 0.25;

/// Samples of blocks, but for a common factor: the least work for a sum of squared errors takes them in
/// proportion to the deviation over the root of the cost [Neyman 1934].
Plane shares_of(const Plane& errors, const Plane& costs, const Rule& rule) {
  Plane shares(errors.size());
  for (std::size_t i = 0; i < shares.size(); ++i) {
    shares[i] = std::sqrt(errors[i]);
    if (rule.gentle) shares[i] = std::sqrt(shares[i]);
    shares[i] /= std::sqrt(costs[i]);
  }
  const double mean = sum_of(shares) / static_cast<double>(shares.size());
  for (double& share : shares) share = mean > 0 ? share / mean + rule.least : 1;
  return shares;
}

/// Squared error times cost, over that of equal counts.
double loss_of(const Plane& shares, const Plane& errors, const Plane& costs) {
  double error = 0, cost = 0, even_error = 0, even_cost = 0;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    error += errors[i] / shares[i];
    cost += costs[i] * shares[i];
    even_error += errors[i];
    even_cost += costs[i];
  }
  return even_error > 0 ? error * cost / (even_error * even_cost) : 1;
}

/// Shares of the rule that promises most: one half of the pilot makes them, and the other judges.
Plane best_shares(const FilmRect& blocks, const std::array<Plane, 2>& halves, const Plane& costs) {
  const std::size_t size = costs.size();
  Plane best(size, 1.0), both(size);
  for (std::size_t i = 0; i < size; ++i) both[i] = 0.5 * (halves[0][i] + halves[1][i]);
  std::array<Plane, 2> smooth = halves;
  double least = 1 - kLeastGain;
  for (const int passes : kSmoothing) {
    for (Plane* const plane : {&smooth[0], &smooth[1], &both})
      *plane = smoothed(blocks, std::move(*plane), passes);
    for (const Rule& rule : kRules) {
      const double loss = 0.5 * (loss_of(shares_of(smooth[0], costs, rule), halves[1], costs) +
                                 loss_of(shares_of(smooth[1], costs, rule), halves[0], costs));
      if (loss >= least) continue;
      least = loss;
      best = shares_of(both, costs, rule);
    }
  }
  return best;
}

}  // namespace

std::uint32_t good_count(double samples) {
  // Geometric means of neighbours part them. Not a number is as good as none.
  if (!(samples >= 2)) return samples * samples > 2 ? 2 : 1;
  int exponent = 0;
  const double part = std::frexp(std::min<double>(samples, wire::kMaxSamplesPerPixel), &exponent);
  const std::uint32_t half = std::uint32_t{1} << (exponent - 2);  // half the power of two below
  return 4 * part * part < 1.5 ? 2 * half : 4 * part * part < 3 ? 3 * half : 4 * half;
}

double scattered_noise_share(const PixelFilterRecord& filter) {
  const auto share = [&](const FilterAxis& axis) {
    constexpr int kSteps = 4096;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double value = filter_value(
          filter.kind, axis, static_cast<float>((2 * i + 1 - kSteps) * double{axis.radius} / kSteps));
      sum += value * value;
    }
    return sum * 2 * double{axis.radius} / kSteps;
  };
  return share(filter.x) * share(filter.y);
}

SampleCounts plan_samples(const NoiseTarget& target, const Pilot& pilot, double noise_share) {
  const std::size_t size = pilot.values.size();
  std::array<Plane, 2> halves = {Plane(size), Plane(size)};
  Plane costs(size);
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t half : {0u, 1u}) halves[half][i] = double{pilot.values[i].error[half]};
    costs[i] = double{pilot.values[i].cost};
  }
  const Plane shares = best_shares(pilot.blocks, halves, smoothed(pilot.blocks, std::move(costs), 1));

  const std::uint32_t fewest = std::min(wire::kLeastNoiseSamples, target.samples);
  const auto count = [&](double samples) { return std::clamp(good_count(samples), fewest, target.samples); };
  const auto error_with = [&](double factor) {
    double error = 0;
    for (std::size_t i = 0; i < size; ++i)
      error += 0.5 * (halves[0][i] + halves[1][i]) * noise_share / count(factor * shares[i]);
    return error;
  };
  // The least factor with which the picture has the error that is wanted: between those with which all blocks
  // take the fewest, and the most.
  const double wanted = target.noise * target.noise * static_cast<double>(size);
  double low = 0.5 * fewest / *std::ranges::max_element(shares);
  double high = 2.0 * target.samples / *std::ranges::min_element(shares);
  if (error_with(low) <= wanted) high = low;
  while (high > 1.001 * low) {
    const double middle = std::sqrt(low * high);
    (error_with(middle) > wanted ? low : high) = middle;
  }

  SampleCounts plan{pilot.blocks, std::vector<std::uint32_t>(size)};
  for (std::size_t i = 0; i < size; ++i) plan.counts[i] = count(high * shares[i]);
  plan.even = std::ranges::all_of(plan.counts, [&](std::uint32_t n) { return n == plan.counts[0]; });
  return plan;
}

}  // namespace tessera::render
