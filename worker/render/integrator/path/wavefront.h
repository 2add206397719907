// The path tracer as a wavefront: a batch of paths advances one scattering event at a time, 16 paths wide [Laine,
// Karras & Aila 2013].
#pragma once

#include <span>
#include <stop_token>
#include <vector>

#include "render/accel/ray_log.h"
#include "render/film/film_sink.h"
#include "render/film/sample_source.h"
#include "render/film/tile_request.h"
#include "render/integrator/path/path_state.h"
#include "render/integrator/scene_tables.h"
#include "render/integrator/stage_timer.h"
#include "render/light/light.h"

namespace tessera::render::TESSERA_ISA {

class Wavefront {
 public:
  Wavefront(const SceneTables& scene, RenderStats& stats, RayLog* log, std::int32_t max_depth);

  /// All samples of the tile; false when stopped before the end.
  bool render(const TileRequest& tile, FilmSink& film, std::stop_token stop);
  /// Whatever `source` asks for, with a seed that is that much larger; false when stopped before the end.
  bool render(SampleSource& source, std::uint64_t seed_offset, std::stop_token stop);

 private:
  /// The tile's samples of the pixels at `places`.
  bool render_pixels(std::span<const SampleName> places, const TileRequest& tile, FilmSink& film, std::stop_token stop);
  void name_samples(std::span<const SampleName> places, std::uint32_t first_sample, std::uint32_t samples);
  std::size_t next_samples(SampleSource& source);
  std::size_t trace_samples(int count);
  void start_paths(int count);
  void advance(int depth);
  void intersect(int depth);
  void clip_far();
  void shade(int depth);
  /// Copies paths and hits into sorted_, those of one shading group together.
  void sort_by_group();
  void trace_shadow_rays();
  /// Times of rays as the tracer wants them.
  const float* times_of(const Lanes<float>& times) const { return scene_.any_motion ? times : nullptr; }
  /// radiance += more, for samples that are all different.
  void add_radiance(Spectrum more, Int slot, Mask lanes);
  std::size_t finish_samples(int count);
  void drop_bad_samples(int count);

  // Volumetric scenes, see transit.cpp. transit() moves every path on to its next scattering event, march_shadow_rays()
  // shadow rays to their lights.
  void transit(int depth);
  Mask fly(Int path, int depth, int round, Mask active);
  void retrace(int n);
  void end_stuck_paths(int n);
  void march_shadow_rays(int depth);
  int march(int depth, int round, int i, Mask active, int kept);

  // The steps of shade(), for 16 paths; see shade.cpp.
  struct Vertex;
  void add_environment(const Vertex& v, Mask missed);
  void add_emission(const Vertex& v, Mask hit);
  void record_first_hit(const Vertex& v, Mask hit);
  void make_partly_opaque(Vertex& v, Mask hit, int depth);
  Receiver receiver(const Vertex& v) const;
  void sample_one_light(const Vertex& v, Mask events, int depth);
  void scatter_path(const Vertex& v, Mask events, int depth, int& kept);

  const SceneTables& scene_;
  RenderStats& stats_;
  ShadingTimer shading_timer_{stats_.times};
  RayLog* const log_;               // null: nothing is recorded
  const std::int32_t max_depth_;    // scattering events on a path
  SampleName names_[kPadded] = {};  // of the batch
  std::uint64_t seed_ = 0;          // of the sampler
  int alive_ = 0;
  PathState paths_;
  HitState hits_;
  SortedState sorted_;  // scenes with shading groups only
  SampleState samples_;
  ShadowQueue shadows_;
  TransitState transit_;       // volumetric scenes only
  std::vector<float> planes_;  // what the film takes
};

/// The tile's pixels (indices, rows from the top) so that runs of 16, 64, 256 are squares.
std::vector<std::uint32_t> z_order(std::uint32_t width, std::uint32_t height);

}  // namespace tessera::render::TESSERA_ISA
