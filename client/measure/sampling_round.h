// Rounds of jobs that sample cells of a plan. For the sources of sampling.h only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "measure/sampling.h"

namespace tessera::client {

/// Pixels of a cell in the first round: enough to know their spread.
inline constexpr std::uint64_t kFirstPixels = 16;

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

  /// Errors are those of the renderer.
  absl::Status run(const std::vector<std::uint64_t>& wanted, std::uint64_t& seed);
  /// The same, for cells that read all light, by this integrator of the options (its number).
  absl::Status run(std::size_t integrator, const std::vector<std::uint64_t>& wanted, std::uint64_t& seed);

 private:
  absl::Status run(std::optional<std::size_t> integrator, ReadLight light,
                   const std::vector<std::uint64_t>& wanted, std::uint64_t& seed);
  absl::Status finish(std::optional<std::size_t> integrator, ReadLight light, std::uint64_t& seed);
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

}  // namespace tessera::client
