#include "measure/sampling.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "image/metrics.h"
#include "measure/ratio.h"

namespace tessera::client {

namespace {

/// Pixels of a cell in the first round: enough to know their spread.
constexpr std::uint64_t kFirstPixels = 16;
constexpr std::uint32_t kMostSamplesPerPixel = 64;
/// A job has no more pixels; a film is so wide, or less.
constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 20;
constexpr std::uint32_t kWidth = 256;
/// The spread of few pixels is uncertain: a round at most multiplies by this what it is judged by.
constexpr double kMostGrowth = 16;
constexpr int kMostRounds = 64;
/// Rounds that go on for heavy tails alone: each doubles, and some tails never end. A warning names the
/// figures.
constexpr int kMostHeavyRounds = 8;

/// A run of cells of one probe that a job has pixels for, in the order of the pixels.
struct CellPixels {
  std::size_t cell;
  std::uint64_t pixels;
};

/// Renders jobs that give cells so many more pixels each.
class Round {
 public:
  Round(const MeasurePlan& plan, const SamplingOptions& options, const RenderProbes& render,
        SampledCells& sampled, SamplingProgress& progress)
      : plan_(plan), options_(options), render_(render), sampled_(sampled), progress_(progress) {}

  absl::Status run(const std::vector<std::uint64_t>& wanted, std::uint64_t& seed);

 private:
  absl::Status run(ReadLight light, const std::vector<std::uint64_t>& wanted, std::uint64_t& seed);
  absl::Status finish(ReadLight light, std::uint64_t& seed);
  v1::Probe& begin(const PlannedProbe& probe, std::size_t cell);
  bool time_is_up() const { return options_.time_is_up && options_.time_is_up(); }

  const MeasurePlan& plan_;
  const SamplingOptions& options_;
  const RenderProbes& render_;
  SampledCells& sampled_;
  SamplingProgress& progress_;
  v1::ProbeCamera camera_;
  std::vector<SceneBlob> blobs_;
  std::vector<CellPixels> order_;
  std::uint64_t pixels_ = 0;
};

absl::Status Round::finish(ReadLight light, std::uint64_t& seed) {
  if (pixels_ == 0) return absl::OkStatus();
  ProbeJob job;
  job.camera.Swap(&camera_);
  job.blobs = std::exchange(blobs_, {});
  job.light = light;
  job.spp = sampled_.samples_per_pixel;
  job.width = static_cast<std::uint32_t>(std::min<std::uint64_t>(kWidth, pixels_));
  job.height = static_cast<std::uint32_t>((pixels_ + job.width - 1) / job.width);
  job.seed = seed++;
  const auto picture = render_(job);
  if (!picture.ok()) return picture.status();
  if (picture->pixels.size() < pixels_) return absl::InternalError("a picture of probes lacks pixels");
  sampled_.cpu_seconds += picture->cpu_seconds;
  std::size_t pixel = 0;
  for (const CellPixels& run : order_) {
    for (std::uint64_t i = 0; i < run.pixels; ++i) sampled_.cells[run.cell].add(picture->pixels[pixel++]);
  }
  progress_.samples += pixels_ * sampled_.samples_per_pixel;
  if (options_.progress) options_.progress(progress_);
  camera_.Clear(), order_.clear(), pixels_ = 0;
  return absl::OkStatus();
}

/// Adds the probe to the job, without pixels: of a cell that is a triangle, the one of that.
v1::Probe& Round::begin(const PlannedProbe& probe, std::size_t cell) {
  v1::Probe& added = *camera_.add_probes();
  added = probe.probe;
  if (!probe.triangles.empty()) place_on(probe.triangles[cell], added);
  added.mutable_pixels_of_cells()->Resize(probe.triangles.empty() ? static_cast<int>(probe.cells) : 1, 0);
  for (const SceneBlob& blob : probe.blobs) {
    const auto is_it = [&](const SceneBlob& other) { return other.ref.digest() == blob.ref.digest(); };
    if (std::ranges::none_of(blobs_, is_it)) blobs_.push_back(blob);
  }
  return added;
}

absl::Status Round::run(ReadLight light, const std::vector<std::uint64_t>& wanted, std::uint64_t& seed) {
  for (const PlannedProbe& probe : plan_.probes) {
    if (probe.light != light) continue;
    v1::Probe* added = nullptr;
    for (std::size_t i = 0; i < probe.cells; ++i) {
      const std::size_t cell = probe.first_cell + i;
      const bool is_triangle = !probe.triangles.empty();
      if (is_triangle && !(probe.triangles[i].area() > 0)) continue;
      if (is_triangle) added = nullptr;
      std::uint64_t left = wanted[cell];
      while (left > 0) {
        if (pixels_ == kMostPixels) {
          if (absl::Status s = finish(light, seed); !s.ok()) return s;
          added = nullptr;
          if (time_is_up()) {
            sampled_.stopped = true;
            return absl::OkStatus();
          }
        }
        if (added == nullptr) added = &begin(probe, i);
        const std::uint64_t now = std::min(left, kMostPixels - pixels_);
        added->set_pixels_of_cells(is_triangle ? 0 : static_cast<int>(i), static_cast<std::uint32_t>(now));
        order_.push_back({cell, now});
        pixels_ += now, left -= now;
      }
    }
  }
  return finish(light, seed);
}

absl::Status Round::run(const std::vector<std::uint64_t>& wanted, std::uint64_t& seed) {
  for (const ReadLight light : {ReadLight::kAll, ReadLight::kStraight}) {
    if (absl::Status s = run(light, wanted, seed); !s.ok()) return s;
  }
  return absl::OkStatus();
}

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

/// Says after a round which cells need more pixels.
class Judge {
 public:
  /// `error`: that is wanted; 0: none is. `heavy_tails_go_on`: figures that rest on one pixel are not sure
  /// yet, however small their spread.
  Judge(const MeasurePlan& plan, double error, bool heavy_tails_go_on, const SampledCells& sampled)
      : plan_(plan),
        error_(error),
        heavy_tails_go_on_(heavy_tails_go_on),
        sampled_(sampled),
        wanted_(plan.cells, 0) {}

  void judge_all() {
    for (const PlannedMeter& meter : plan_.meters) {
      if (meter.ratio) judge_ratio(meter);
      for (const PlannedReading& reading : meter.readings) {
        const double more = note(relative_error(reading, sampled_), meter);
        const bool is_heavy = error_ > 0 && heavy_tails_go_on_ && has_heavy_tail(reading, sampled_);
        ask(reading, more > 0 ? more : is_heavy ? 1 : 0);
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
  const bool heavy_tails_go_on_;
  const SampledCells& sampled_;
  std::vector<std::uint64_t> wanted_;
  double worst_ = 0;
  std::string worst_meter_;
  bool is_done_ = true;
};

}  // namespace

absl::StatusOr<SampledCells> sample_cells(const MeasurePlan& plan, const SamplingOptions& options,
                                          const RenderProbes& render) {
  SampledCells sampled;
  sampled.cells.resize(plan.cells);
  if (plan.cells == 0) return sampled;
  const std::uint64_t samples = options.error > 0 ? kFirstPixels * kMostSamplesPerPixel : options.samples;
  sampled.samples_per_pixel = static_cast<std::uint32_t>(
      std::clamp<std::uint64_t>(std::bit_floor(samples / kFirstPixels), 1, kMostSamplesPerPixel));
  const std::uint64_t pixels =
      std::max(kFirstPixels, (samples + sampled.samples_per_pixel - 1) / sampled.samples_per_pixel);
  std::vector<std::uint64_t> wanted(plan.cells, pixels);
  std::uint64_t seed = options.seed;
  SamplingProgress progress;
  for (int round = 0; round < kMostRounds; ++round) {
    if (absl::Status s = Round(plan, options, render, sampled, progress).run(wanted, seed); !s.ok()) return s;
    progress.rounds = round + 1;
    Judge judge(plan, options.error, round < kMostHeavyRounds, sampled);
    judge.judge_all();
    progress.worst = judge.worst(), progress.worst_meter = judge.worst_meter();
    if (options.progress) options.progress(progress);
    if (judge.is_done() || sampled.stopped) break;
    if (options.time_is_up && options.time_is_up()) {
      sampled.stopped = true;
      break;
    }
    wanted = judge.take_wanted();
  }
  return sampled;
}

}  // namespace tessera::client
