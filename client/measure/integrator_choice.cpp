#include "measure/integrator_choice.h"

#include <algorithm>
#include <cmath>

#include "measure/ratio.h"
#include "wire/algorithm.h"

namespace tessera::client {

namespace {

/// An integrator takes the place of the usual one where it is so many times as good: the spread of few pixels
/// is known to a third.
constexpr double kWorthIt = 1.5;
/// Errors by which figures of two integrators may differ that find the same light.
constexpr double kFarApart = 6;

/// Returns whether `other` finds more light than `one` by more than both errors.
bool finds_more(const PlannedMeter& meter, const SampledCells& other, const SampledCells& one) {
  for (const PlannedReading& reading : meter.readings) {
    for (const CellTerm& term : reading.terms) {
      const CellSums &a = other.cells[term.cell], &b = one.cells[term.cell];
      if (a.pixels() < 2 || b.pixels() < 2) continue;
      const double error = std::sqrt(a.variance(term.channel) + b.variance(term.channel));
      const double more = a.mean(term.channel) - b.mean(term.channel);
      if (more > kFarApart * error + 1e-4 * a.mean(term.channel)) return true;
    }
  }
  return false;
}

bool lacks_pixels(const PlannedMeter& meter, const SampledCells& sampled) {
  return std::ranges::any_of(meter.readings, [&](const PlannedReading& reading) {
    return std::ranges::any_of(reading.terms,
                               [&](const CellTerm& term) { return sampled.cells[term.cell].pixels() == 0; });
  });
}

/// Whether more than a quarter of the figures rest on single pixels. Of many, some do by chance.
bool has_heavy_tails(const PlannedMeter& meter, const SampledCells& sampled) {
  const auto heavy = std::ranges::count_if(
      meter.readings, [&](const PlannedReading& reading) { return has_heavy_tail(reading, sampled); });
  return 4 * static_cast<std::size_t>(heavy) > meter.readings.size();
}

/// The sum of the figures' squared errors relative to themselves as `scale` has them.
double squared_errors(const PlannedMeter& meter, const SampledCells& sampled, const SampledCells& scale) {
  double sum = 0;
  for (const PlannedReading& reading : meter.readings) {
    double whole = std::abs(reading.constant);
    for (const CellTerm& term : reading.terms)
      whole += std::abs(term.factor * scale.cells[term.cell].mean(term.channel));
    double squares = 0;
    for (const CellTerm& term : reading.terms)
      squares += term.factor * term.factor * sampled.cells[term.cell].variance(term.channel);
    if (whole > 0) sum += squares / (whole * whole);
  }
  return sum;
}

}  // namespace

bool can_read(const std::string& integrator, const v1::Probe& probe) {
  const wire::AlgorithmTraits* const algorithm = wire::find_algorithm(integrator);
  if (algorithm == nullptr || !algorithm->reads_probes) return false;
  // Light tracing joins vertices to all that it reads.
  if (algorithm->blindness != wire::Blindness::kMirrorImages) return true;
  return probe.kind() != v1::Probe::EXITANCE &&
         (probe.kind() != v1::Probe::CONE || probe.field_degrees() > 0);
}

std::vector<bool> meters_to_try(const MeasurePlan& plan, double error, const SampledCells& sampled) {
  // Errors fall with the root of the pixels.
  const double far = std::sqrt(static_cast<double>(kTrialsThatPay)) * error;
  std::vector<bool> tries(plan.meters.size(), error <= 0);
  for (std::size_t m = 0; m < plan.meters.size(); ++m) {
    const PlannedMeter& meter = plan.meters[m];
    for (const PlannedReading& reading : meter.readings)
      if (relative_error(reading, sampled) > far) tries[m] = true;
    if (!meter.ratio) continue;
    const PlannedMeter &of = plan.meters[meter.ratio->of], &over = plan.meters[meter.ratio->over];
    for (std::size_t i = 0; i < of.readings.size() && !over.readings.empty(); ++i) {
      const Figure figure =
          ratio_of(figure_of(of.readings[i], sampled),
                   figure_of(over.readings[partner_of(i, over.readings.size())], sampled), meter.ratio->kind);
      if (relative_error_of_ratio(figure, meter.ratio->kind) > far)
        tries[meter.ratio->of] = tries[meter.ratio->over] = true;
    }
  }
  return tries;
}

std::vector<std::vector<std::size_t>> cells_of_meters(const MeasurePlan& plan) {
  std::vector<bool> reads_all(plan.cells, true);
  for (const PlannedProbe& probe : plan.probes) {
    for (std::size_t i = 0; i < probe.cells; ++i)
      reads_all[probe.first_cell + i] = probe.light == ReadLight::kAll;
  }
  std::vector<std::vector<std::size_t>> cells(plan.meters.size());
  for (std::size_t m = 0; m < plan.meters.size(); ++m) {
    const auto add = [&](std::size_t cell) {
      if (reads_all[cell]) cells[m].push_back(cell);
    };
    for (const PlannedReading& reading : plan.meters[m].readings) {
      for (const CellTerm& term : reading.terms) add(term.cell);
      if (reading.over) add(*reading.over);
    }
    std::ranges::sort(cells[m]);
    const auto twice = std::ranges::unique(cells[m]);
    cells[m].erase(twice.begin(), twice.end());
  }
  return cells;
}

std::size_t best_trial(const PlannedMeter& meter, const std::vector<Trial>& trials) {
  const auto is_out = [&](std::size_t t) {
    const SampledCells& own = trials[t].sampled;
    if (lacks_pixels(meter, own) || has_heavy_tails(meter, own)) return true;
    return std::ranges::any_of(trials,
                               [&](const Trial& other) { return finds_more(meter, other.sampled, own); });
  };
  const auto effort_of = [&](std::size_t t) {
    return trials[t].rays_per_pixel * squared_errors(meter, trials[t].sampled, trials[0].sampled);
  };
  std::size_t best = 0;
  bool is_first_out = is_out(0);
  double least = effort_of(0) / kWorthIt;
  for (std::size_t t = 1; t < trials.size(); ++t) {
    if (is_out(t)) continue;
    if (is_first_out || effort_of(t) < least) best = t, least = effort_of(t), is_first_out = false;
  }
  return best;
}

}  // namespace tessera::client
