// Radiosity on the farm: an estimate of all light by links between whole sides, links by what the estimate
// says of their errors, and the solution.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string_view>

#include "render/integrator/integrator.h"
#include "render/textbook/radiosity/display.h"
#include "render/textbook/radiosity/solve.h"

namespace tessera::render::TESSERA_ISA::radiosity {

/// "estimate", "links" and "solution" (wire/algorithm.cpp).
extern const AlgorithmPhase kPhases[3];

/// Light by links between whole sides, which tells how exact the final ones have to be.
class Estimate {
 public:
  explicit Estimate(Forest forest) : forest_(std::move(forest)) {}

  /// Solves for it; threads that call this take turns, a sweep each. False when stopped before the end.
  bool finish(double residual, std::stop_token stop);
  // Once it is finished.
  const Brightness& brightness() const { return brightness_; }
  double mean_irradiance() const { return mean_irradiance_; }

 private:
  std::mutex mutex_;
  std::optional<Forest> forest_;  // none once it is finished
  Brightness brightness_;
  double mean_irradiance_ = 0;
};

/// Data that a phase reads of those before it.
struct Linked final : Prepared {
  explicit Linked(const SceneTables& scene) : surfaces(scene.shapes), clusters(surfaces) {}

  const Surfaces surfaces;
  const Clusters clusters;
  std::unique_ptr<Estimate> estimate;  // guides the final links
  Links links;                         // links of the solution
};

/// Data that the picture reads.
struct Solved final : Prepared {
  explicit Solved(const SceneTables& scene) : surfaces(scene.shapes) {}

  const Surfaces surfaces;
  Solution solution;
};

std::unique_ptr<const Prepared> prepare(const SceneTables& scene, std::span<const std::string_view> blobs);

}  // namespace tessera::render::TESSERA_ISA::radiosity
