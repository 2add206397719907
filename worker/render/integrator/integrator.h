// The interface between algorithms and the rest of the renderer.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>

#include "render/accel/ray_query.h"
#include "render/film/film.h"
#include "render/film/prepared.h"
#include "render/film/sample_source.h"
#include "render/film/tile_request.h"
#include "render/integrator/scene_tables.h"

namespace tessera::render {

/// Surroundings of an integrator, which outlive it.
struct IntegratorContext {
  const SceneTables& scene;
  const RayQuery& rays;
  std::uint64_t seed;                  // the sampler's
  RenderStats& stats;                  // times in ticks of Kernel::clock_ticks
  const Prepared* prepared = nullptr;  // made by the algorithm's own `prepare`; null where it has none
};

/// Finds light, on one thread. One is made for each unit of work.
class Integrator {
 public:
  virtual ~Integrator() = default;
  /// Takes all samples that `work` names, and whatever else the algorithm finds, to `film`. False when it was
  /// stopped before the end.
  virtual bool render(SampleSource& work, Film& film, std::stop_token stop) = 0;
};

/// One of an algorithm's phases, in the order of AlgorithmTraits::phases. The same arguments give the same
/// bytes on all machines of an arithmetic class: farms compare them.
struct AlgorithmPhase {
  /// Makes one part, from what phases before have made. False when stopped, or where it cannot read these.
  bool (*make)(const IntegratorContext& context, const PartRequest& part, std::stop_token stop,
               std::string& blob);
  /// Makes one blob of neighbouring ones, parts or merged before. False where they are not the phase's.
  bool (*merge)(std::span<const std::string_view> blobs, std::string& merged);
};

/// A row of the table that a kernel module exports. What it can do is in wire/algorithm.h, under its name.
struct Algorithm {
  std::string_view name;
  std::unique_ptr<Integrator> (*make)(const IntegratorContext& context);
  std::span<const AlgorithmPhase> phases = {};
  /// Reads the blobs of the first phases, all of them for the picture. Null where they are not the phases'.
  /// An algorithm without phases is asked once a scene and view, before the first unit, and given none.
  std::unique_ptr<const Prepared> (*prepare)(const SceneTables& scene,
                                             std::span<const std::string_view> blobs) = nullptr;
};

}  // namespace tessera::render
