// Radiosity on the farm: an estimate of all light by links between whole sides, links by what the estimate
// says of their errors, and the solution.
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "render/integrator/integrator.h"
#include "render/integrator/radiosity/display.h"

namespace tessera::render::TESSERA_ISA::radiosity {

/// "estimate", "links" and "solution" (wire/algorithm.cpp).
extern const AlgorithmPhase kPhases[3];

/// What a phase reads of those before it.
struct Linked final : Prepared {
  Linked(const SceneTables& scene) : surfaces(scene.shapes), clusters(surfaces) {}

  const Surfaces surfaces;
  const Clusters clusters;
  Brightness brightness;  // by the estimate
  double mean_irradiance = 0;
  Links links;  // for the solution
};

/// What the picture reads.
struct Solved final : Prepared {
  explicit Solved(const SceneTables& scene) : surfaces(scene.shapes) {}

  const Surfaces surfaces;
  Solution solution;
};

std::unique_ptr<const Prepared> prepare(const SceneTables& scene, std::span<const std::string_view> blobs);

}  // namespace tessera::render::TESSERA_ISA::radiosity
