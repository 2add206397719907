// The seam between code that runs everywhere and the kernels, which are compiled once an ISA into modules of their own.
#pragma once

#include <stop_token>
#include <string>

#include "render/accel/geometry_callbacks.h"
#include "render/accel/ray_log.h"
#include "render/film/film_sink.h"
#include "render/film/sample_source.h"
#include "render/film/tile_request.h"
#include "render/integrator/scene_tables.h"

namespace tessera::render {

struct Kernel {
  const char* isa;
  GeometryCallbacks callbacks;
  /// Renders a tile on the calling thread; false when stopped. Rays are recorded where `log` is not null.
  bool (*render_path)(const SceneTables& scene, const TileRequest& tile, std::stop_token stop, FilmSink& film,
                      RenderStats& stats, RayLog* log);
  /// As render_path, of whatever samples are asked for.
  bool (*render_samples)(const SceneTables& scene, SampleSource& source, std::uint64_t seed_offset,
                         std::stop_token stop, RenderStats& stats);
  /// As render_path, by light tracing: the unit's pixels gather what lands on them of paths over the whole film.
  bool (*render_light)(const SceneTables& scene, const TileRequest& tile, std::stop_token stop, FilmSink& film,
                       RenderStats& stats);
  /// Traces the rays of a log again, with no shading; returns how many met something.
  std::uint64_t (*replay_rays)(RTCScene scene, const RayLog& log);
  /// The counter that RenderStats::times are read from, in its own unit.
  std::uint64_t (*clock_ticks)();
  /// How this machine rounds with these kernels (accel/arithmetic.h).
  std::uint32_t (*arithmetic_checksum)();
};

/// The one symbol that a kernel module exports.
using KernelEntry = const Kernel* (*)();
inline constexpr const char* kKernelEntryName = "tessera_kernel";

/// The kernel of an ISA, loaded on first use; null when this build or this processor lacks it.
const Kernel* find_kernel(const std::string& isa);

}  // namespace tessera::render
