// The interface between algorithms and the rest of the renderer.
#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>
#include <string_view>

#include "render/accel/ray_query.h"
#include "render/film/film.h"
#include "render/film/sample_source.h"
#include "render/film/tile_request.h"
#include "render/integrator/scene_tables.h"

namespace tessera::render {

/// Surroundings of an integrator, which outlive it.
struct IntegratorContext {
  const SceneTables& scene;
  const RayQuery& rays;
  std::uint64_t seed;  // of the sampler
  RenderStats& stats;  // times in ticks of Kernel::clock_ticks
};

/// Finds light, on one thread. One is made for each unit of work.
class Integrator {
 public:
  virtual ~Integrator() = default;
  /// Takes all samples that `work` names, and whatever else the algorithm finds, to `film`. False when it was
  /// stopped before the end.
  virtual bool render(SampleSource& work, Film& film, std::stop_token stop) = 0;
};

/// A row of the table that a kernel module exports. What it can do is in wire/algorithm.h, under its name.
struct Algorithm {
  std::string_view name;
  std::unique_ptr<Integrator> (*make)(const IntegratorContext& context);
};

}  // namespace tessera::render
