#include "measure/sampling.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "image/metrics.h"
#include "measure/integrator_choice.h"
#include "measure/ratio.h"
#include "measure/sampling_round.h"

namespace tessera::client {

namespace {

constexpr std::uint32_t kMostSamplesPerPixel = 64;
/// Pixels that cells have first by an integrator that was chosen, as many as paid for the choice at least:
/// where few bright paths matter, the first figures that seem sure are too dark.
constexpr std::uint64_t kPixelsAfterChoice = kTrialsThatPay * kFirstPixels;
/// The spread of few pixels is uncertain: a round at most multiplies by this what it is judged by.
constexpr double kMostGrowth = 16;
constexpr int kMostRounds = 64;
/// Rounds that go on for heavy tails alone: each doubles, and some tails never end. A warning names the
/// figures.
constexpr int kMostHeavyRounds = 8;
/// Rounds that go on for figures without any light so far, which a small lamp may have yet: each quadruples.
constexpr int kMostBlackRounds = 3;

/// How many more pixels the cells of a figure need, for each that they have, `now` being its relative error.
double more_for(double now, double error) {
  if (!(now > error)) return 0;
  // The variance may be larger than it looks: a tenth more saves another round.
  return std::clamp(1.1 * (now / error) * (now / error) - 1, 0.25, kMostGrowth - 1);
}

}  // namespace

bool has_heavy_tail(const PlannedReading& reading, const SampledCells& sampled) {
  const CellSums* widest = nullptr;
  double most = 0;
  for (const CellTerm& term : reading.terms) {
    const CellSums& cell = sampled.cells[term.cell];
    const double variance = term.factor * term.factor * cell.variance(term.channel);
    if (variance > most) most = variance, widest = &cell;
  }
  return widest != nullptr && widest->largest_share() > kHeavyShare;
}

Figure figure_of(const PlannedReading& reading, const SampledCells& sampled) {
  Figure figure;
  figure.value = reading.constant;
  double variance = 0, by_freedom = 0;
  const auto add_variance = [&](const CellSums& cell, double part) {
    // The time was up before this cell was read.
    if (cell.pixels() == 0) figure.value = std::numeric_limits<double>::quiet_NaN();
    variance += part;
    if (cell.pixels() > 1) by_freedom += part * part / static_cast<double>(cell.pixels() - 1);
    figure.samples += cell.pixels() * sampled.samples_per_pixel;
  };
  for (const CellTerm& term : reading.terms) {
    const CellSums& cell = sampled.cells[term.cell];
    figure.value += term.factor * cell.mean(term.channel);
    add_variance(cell, term.factor * term.factor * cell.variance(term.channel));
  }
  if (reading.over) {
    const CellSums& cell = sampled.cells[*reading.over];
    const double mean = cell.mean(ReadingChannel::kLuminance), square = mean * mean;
    if (mean == 0) return {};
    figure.value /= mean;
    variance /= square, by_freedom /= square * square;
    add_variance(cell, figure.value * figure.value * cell.variance(ReadingChannel::kLuminance) / square);
  }
  figure.standard_error = std::sqrt(variance);
  // Degrees of freedom of a sum of variances [Satterthwaite 1946].
  if (by_freedom > 0) figure.degrees_of_freedom = variance * variance / by_freedom;
  return figure;
}

double relative_error(const PlannedReading& reading, const SampledCells& sampled) {
  const Figure figure = figure_of(reading, sampled);
  if (!(figure.standard_error > 0)) return 0;
  double whole = std::abs(reading.constant);
  for (const CellTerm& term : reading.terms)
    whole += std::abs(term.factor * sampled.cells[term.cell].mean(term.channel));
  if (reading.over) whole /= std::abs(sampled.cells[*reading.over].mean(ReadingChannel::kLuminance));
  return student_t_quantile(0.05, std::max(1.0, figure.degrees_of_freedom)) * figure.standard_error / whole;
}

namespace {

/// Whether no sample of a reading has seen light.
bool is_black(const PlannedReading& reading, const SampledCells& sampled) {
  return !reading.terms.empty() && std::ranges::all_of(reading.terms, [&](const CellTerm& term) {
    const CellSums& cell = sampled.cells[term.cell];
    return cell.mean(term.channel) == 0 && cell.variance(term.channel) == 0;
  });
}

/// Says after a round which cells need more pixels.
class Judge {
 public:
  /// `error`: that is wanted; 0: none is. In early rounds, figures that rest on one pixel or have seen no
  /// light are not sure yet, however small their spread.
  Judge(const MeasurePlan& plan, double error, int round, const SampledCells& sampled)
      : plan_(plan), error_(error), round_(round), sampled_(sampled), wanted_(plan.cells, 0) {}

  void judge_all() {
    for (const PlannedMeter& meter : plan_.meters) {
      if (meter.ratio) judge_ratio(meter);
      for (const PlannedReading& reading : meter.readings) {
        const double more = note(relative_error(reading, sampled_), meter);
        ask(reading, more > 0 ? more : more_in_spite_of_spread(reading));
      }
    }
  }

  double worst() const { return worst_; }
  const std::string& worst_meter() const { return worst_meter_; }
  bool is_done() const { return is_done_; }
  std::vector<std::uint64_t> take_wanted() { return std::move(wanted_); }

 private:
  void judge_ratio(const PlannedMeter& meter) {
    const PlannedMeter &of = plan_.meters[meter.ratio->of], &over = plan_.meters[meter.ratio->over];
    // Parts of pictures have their own numbers of samples.
    if (of.apart || over.apart) return;
    for (std::size_t i = 0; i < of.readings.size(); ++i) {
      const PlannedReading& below = over.readings[partner_of(i, over.readings.size())];
      const auto kind = meter.ratio->kind;
      const Figure figure = ratio_of(figure_of(of.readings[i], sampled_), figure_of(below, sampled_), kind);
      const double more = note(relative_error_of_ratio(figure, kind), meter);
      ask(of.readings[i], more), ask(below, more);
    }
  }

  double more_in_spite_of_spread(const PlannedReading& reading) const {
    if (error_ == 0) return 0;
    if (round_ < kMostBlackRounds && is_black(reading, sampled_)) return 3;
    return round_ < kMostHeavyRounds && has_heavy_tail(reading, sampled_) ? 1 : 0;
  }

  /// Takes note of a figure's error; returns how many more pixels it needs, for each that it has.
  double note(double now, const PlannedMeter& meter) {
    if (now > worst_) worst_ = now, worst_meter_ = meter.name;
    return error_ > 0 ? more_for(now, error_) : 0;
  }

  void ask(const PlannedReading& reading, double more) {
    if (more == 0) return;
    is_done_ = false;
    for (const CellTerm& term : reading.terms) ask(term.cell, more);
    if (reading.over) ask(*reading.over, more);
  }
  void ask(std::size_t cell, double more) {
    const double has = static_cast<double>(sampled_.cells[cell].pixels());
    wanted_[cell] = std::max(wanted_[cell], static_cast<std::uint64_t>(std::ceil(has * more)));
  }

  const MeasurePlan& plan_;
  const double error_;
  const int round_;
  const SampledCells& sampled_;
  std::vector<std::uint64_t> wanted_;
  double worst_ = 0;
  std::string worst_meter_;
  bool is_done_ = true;
};

/// Samples the cells of a plan.
class CellSampler {
 public:
  CellSampler(const MeasurePlan& plan, const SamplingOptions& options, const RenderProbes& render)
      : plan_(plan), options_(options), render_(render), seed_(options.seed) {}

  absl::StatusOr<SampledCells> run();

 private:
  absl::Status run_round(const std::vector<std::uint64_t>& wanted) {
    return Round(plan_, options_, render_, sampled_, progress_).run(wanted, seed_);
  }
  /// Chooses each meter's integrator after kFirstPixels pixels of all cells by the first one; what was read
  /// for the choice is forgotten. Returns how many pixels cells are to have next.
  absl::StatusOr<std::vector<std::uint64_t>> choose(std::uint64_t pixels);
  absl::StatusOr<Trial> try_integrator(std::size_t number, const std::vector<bool>& is_tried);
  std::vector<std::uint64_t> judge(int round, bool& is_done);
  bool time_is_up() const { return options_.time_is_up && options_.time_is_up(); }

  const MeasurePlan& plan_;
  const SamplingOptions& options_;
  const RenderProbes& render_;
  std::uint64_t seed_;
  SampledCells sampled_;
  SamplingProgress progress_;
};

std::vector<std::uint64_t> CellSampler::judge(int round, bool& is_done) {
  progress_.rounds = round + 1;
  Judge judge(plan_, options_.error, round, sampled_);
  judge.judge_all();
  progress_.worst = judge.worst(), progress_.worst_meter = judge.worst_meter();
  if (options_.progress) options_.progress(progress_);
  is_done = judge.is_done();
  return judge.take_wanted();
}

absl::StatusOr<Trial> CellSampler::try_integrator(std::size_t number, const std::vector<bool>& is_tried) {
  Trial trial;
  trial.sampled.samples_per_pixel = sampled_.samples_per_pixel;
  trial.sampled.cells = sampled_.cells;
  std::vector<std::uint64_t> wanted(plan_.cells, 0);
  std::uint64_t pixels = 0;
  for (const PlannedProbe& probe : plan_.probes) {
    for (std::size_t cell = probe.first_cell; cell < probe.first_cell + probe.cells; ++cell) {
      if (!is_tried[cell]) continue;
      trial.sampled.cells[cell] = {};
      if (can_read(options_.integrators[number], probe.probe)) wanted[cell] = kFirstPixels;
      pixels += wanted[cell];
    }
  }
  absl::Status tried = Round(plan_, options_, render_, trial.sampled, progress_).run(number, wanted, seed_);
  sampled_.cpu_seconds += trial.sampled.cpu_seconds;
  sampled_.stopped |= trial.sampled.stopped;
  // The scene is not for all integrators.
  if (!tried.ok() && !absl::IsInvalidArgument(tried)) return tried;
  if (!tried.ok()) {
    for (std::size_t cell = 0; cell < plan_.cells; ++cell)
      if (is_tried[cell]) trial.sampled.cells[cell] = {};
  }
  trial.rays_per_pixel = std::max(
      1.0, static_cast<double>(trial.sampled.rays) / static_cast<double>(std::max<std::uint64_t>(1, pixels)));
  return trial;
}

absl::StatusOr<std::vector<std::uint64_t>> CellSampler::choose(std::uint64_t pixels) {
  const std::vector<std::vector<std::size_t>> cells = cells_of_meters(plan_);
  const std::vector<bool> tries = meters_to_try(plan_, options_.error, sampled_);
  std::vector<bool> is_tried(plan_.cells, false);
  std::uint64_t read = 0;
  for (std::size_t m = 0; m < cells.size(); ++m) {
    read += kFirstPixels * cells[m].size();
    for (const std::size_t cell : cells[m]) is_tried[cell] = tries[m];
  }
  std::vector<Trial> trials;
  trials.push_back(
      {.sampled = sampled_,
       .rays_per_pixel = std::max(
           1.0, static_cast<double>(sampled_.rays) / static_cast<double>(std::max<std::uint64_t>(1, read)))});
  const bool any = std::ranges::find(is_tried, true) != is_tried.end();
  for (std::size_t i = 1; any && i < options_.integrators.size() && !sampled_.stopped; ++i) {
    auto trial = try_integrator(i, is_tried);
    if (!trial.ok()) return trial.status();
    trials.push_back(*std::move(trial));
    sampled_.stopped |= time_is_up();
  }
  bool is_done = true;
  std::vector<std::uint64_t> wanted = judge(0, is_done);
  if (sampled_.stopped) return wanted;
  for (std::size_t m = 0; m < cells.size(); ++m) {
    if (!tries[m] || cells[m].empty()) continue;
    sampled_.integrator_of_meter[m] = best_trial(plan_.meters[m], trials);
    for (const std::size_t cell : cells[m]) {
      sampled_.integrator_of_cell[cell] = sampled_.integrator_of_meter[m];
      sampled_.cells[cell] = {};
      wanted[cell] = kPixelsAfterChoice;
    }
  }
  if (options_.error > 0) return wanted;
  for (std::size_t cell = 0; cell < plan_.cells; ++cell)
    wanted[cell] = pixels - std::min(pixels, sampled_.cells[cell].pixels());
  return wanted;
}

absl::StatusOr<SampledCells> CellSampler::run() {
  sampled_.cells.resize(plan_.cells);
  if (plan_.cells == 0) return std::move(sampled_);
  const std::uint64_t samples = options_.error > 0 ? kFirstPixels * kMostSamplesPerPixel : options_.samples;
  sampled_.samples_per_pixel = static_cast<std::uint32_t>(
      std::clamp<std::uint64_t>(std::bit_floor(samples / kFirstPixels), 1, kMostSamplesPerPixel));
  const std::uint64_t pixels =
      std::max(kFirstPixels, (samples + sampled_.samples_per_pixel - 1) / sampled_.samples_per_pixel);
  const bool chooses =
      options_.integrators.size() > 1 && (options_.error > 0 || pixels >= kTrialsThatPay * kFirstPixels);
  if (chooses) {
    sampled_.integrator_of_cell.assign(plan_.cells, 0);
    sampled_.integrator_of_meter.assign(plan_.meters.size(), 0);
  }
  std::vector<std::uint64_t> wanted(plan_.cells, chooses ? kFirstPixels : pixels);
  for (int round = 0; round < kMostRounds; ++round) {
    if (absl::Status s = run_round(wanted); !s.ok()) return s;
    bool is_done = true;
    // Readings for a choice are gone: a round follows it whatever the time.
    const bool chooses_now = round == 0 && chooses && !sampled_.stopped && !time_is_up();
    if (chooses_now) {
      auto next = choose(pixels);
      if (!next.ok()) return next.status();
      wanted = *std::move(next);
      is_done = std::ranges::all_of(wanted, [](std::uint64_t more) { return more == 0; });
    } else {
      wanted = judge(round, is_done);
    }
    if (is_done || sampled_.stopped) break;
    if (!chooses_now && time_is_up()) {
      sampled_.stopped = true;
      break;
    }
  }
  return std::move(sampled_);
}

}  // namespace

absl::StatusOr<SampledCells> sample_cells(const MeasurePlan& plan, const SamplingOptions& options,
                                          const RenderProbes& render) {
  return CellSampler(plan, options, render).run();
}

}  // namespace tessera::client
