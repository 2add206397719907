// Sampling what probes read, until their figures are as sure as they are wanted.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "measure/plan.h"
#include "measure/reading_channels.h"
#include "tessera/v1/camera.pb.h"

namespace tessera::client {

/// A picture whose pixels are readings: rows of `width` pixels, each the mean of `spp` samples.
struct ProbeJob {
  v1::ProbeCamera camera;
  std::vector<SceneBlob> blobs;  // meshes of the probes that the scene does not have
  std::uint32_t width = 1, height = 1, spp = 1;
  std::uint64_t seed = 0;
  ReadLight light = ReadLight::kAll;
  std::string integrator = {};  // empty: the usual one
};

struct ProbePicture {
  std::vector<ChannelValues> pixels;
  double cpu_seconds = 0;
  std::uint64_t rays = 0;  // that were traced
};

using RenderProbes = std::function<absl::StatusOr<ProbePicture>(const ProbeJob& job)>;

/// The mean of a cell's pixels, and their spread [Welford 1962].
class CellSums {
 public:
  void add(const ChannelValues& pixel) {
    ++count_;
    for (std::size_t c = 0; c < kReadingChannels; ++c) {
      const double away = pixel[c] - mean_[c];
      mean_[c] += away / static_cast<double>(count_);
      squares_[c] += away * (pixel[c] - mean_[c]);
    }
    largest_ = std::max(largest_, pixel[0]);
  }
  std::uint64_t pixels() const { return count_; }
  double mean(ReadingChannel channel) const { return mean_[static_cast<std::size_t>(channel)]; }
  /// Variance of the mean; 0 for fewer than two pixels.
  double variance(ReadingChannel channel) const {
    if (count_ < 2) return 0;
    const double n = static_cast<double>(count_);
    return squares_[static_cast<std::size_t>(channel)] / (n - 1) / n;
  }
  /// The part of the sum of squares that the brightest pixel has. Where it is large, light comes by rare
  /// paths, and the spread tells too little of the error.
  double largest_share() const {
    const double away = largest_ - mean_[0];
    return squares_[0] > 0 ? std::min(1.0, away * away / squares_[0]) : 0;
  }

 private:
  std::uint64_t count_ = 0;
  ChannelValues mean_{}, squares_{};
  double largest_ = 0;  // luminance
};

/// Beyond this share, one pixel of a cell decides its spread: of sixteen that are normal it happens once in
/// 300 times, of more hardly ever.
inline constexpr double kHeavyShare = 0.5;

/// How far sampling is.
struct SamplingProgress {
  std::uint64_t samples = 0;  // so far, of all cells
  int rounds = 0;             // that are over
  double worst = 0;           // relative_error() of the worst figure after the last of them
  std::string worst_meter = {};
};

struct SamplingOptions {
  std::uint64_t samples = 4096;  // of each cell, where no error is wanted
  double error = 0;              // half of a 95 % interval over its figure; 0: none is wanted
  std::uint64_t seed = 0;
  // Among which each meter's is chosen, the usual one first; fewer than two: nothing is chosen.
  std::vector<std::string> integrators = {};
  std::function<bool()> time_is_up = {};  // ends between two jobs; absent: never
  std::function<void(const SamplingProgress& progress)> progress = {};  // after each job, and each round
};

struct SampledCells {
  std::vector<CellSums> cells;
  std::uint32_t samples_per_pixel = 1;
  double cpu_seconds = 0;
  std::uint64_t rays = 0;  // of jobs that read all light
  bool stopped = false;    // by time_is_up
  // Where integrators are chosen, numbers of SamplingOptions::integrators, by which cells read all light.
  std::vector<std::size_t> integrator_of_cell = {}, integrator_of_meter = {};
};

/// Whether one pixel decides the spread of a figure's largest part: heavy tails.
bool has_heavy_tail(const PlannedReading& reading, const SampledCells& sampled);

/// The figure of a reading.
Figure figure_of(const PlannedReading& reading, const SampledCells& sampled);

/// Half of the 95 % interval of a reading's figure over its value; of one that has differences, whose value
/// may be 0, over all that is added and subtracted. 0 where all samples were equal.
double relative_error(const PlannedReading& reading, const SampledCells& sampled);

/// Samples all cells by rounds of jobs: pixels of a cell are means of as many samples, whose numbers are of
/// no other pixel, so that their spread tells the error. The next round has more pixels for the cells of
/// figures that are not sure enough. What comes out depends on the plan, the options and the scene alone,
/// unless the time is up.
absl::StatusOr<SampledCells> sample_cells(const MeasurePlan& plan, const SamplingOptions& options,
                                          const RenderProbes& render);

}  // namespace tessera::client
