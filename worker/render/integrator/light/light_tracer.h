// Light tracing: paths begin at the lights, and every point that they are scattered at is joined to the camera [Arvo
// 1986; Dutre, Lafortune & Willems 1993]. What it finds easily, caustics above all, is what path tracing hardly finds,
// and the other way round: surfaces seen in a mirror stay black.
//
// A pass traces as many paths as the film has pixels; they may land anywhere on it. Lights that the camera sees
// directly are added by camera rays.
#pragma once

#include <stop_token>
#include <vector>

#include "render/film/film_sink.h"
#include "render/film/tile_request.h"
#include "render/integrator/path/path_state.h"
#include "render/integrator/scene_tables.h"
#include "render/integrator/stage_timer.h"
#include "render/sampling/sampler.h"

namespace tessera::render::TESSERA_ISA {

class LightTracer {
 public:
  LightTracer(const SceneTables& scene, const TileRequest& tile, FilmSink& film, RenderStats& stats);

  /// All passes of the unit; false when stopped before the end.
  bool render(std::stop_token stop);

 private:
  /// Times of rays as the tracer wants them.
  const float* times_of(const Lanes<float>& times) const { return scene_.any_motion ? times : nullptr; }
  bool add_visible_lights(std::uint32_t pass, std::stop_token stop);
  void start_paths(std::int32_t first, std::int32_t count, std::uint32_t pass);
  void advance(int depth);
  void intersect();
  void shade(int depth);
  struct Vertex;
  void make_partly_opaque(Vertex& v, Mask hit);
  /// Whether what is seen at this place of the film touches a pixel of the unit.
  Mask lands(Vec2 film) const;
  void join_to_camera(const Vertex& v, Mask hit);
  void scatter_paths(const Vertex& v, Mask hit, int i, int& kept);
  void trace_connections();
  void splat(float x, float y, const float (&value)[3]);

  const SceneTables& scene_;
  const TileRequest& tile_;
  FilmSink& film_;
  RenderStats& stats_;
  std::vector<std::uint32_t> pixels_;  // of the tile, all
  std::vector<float> planes_;          // R G B A over the tile
  std::size_t stride_;
  int alive_ = 0;
  PathState paths_;
  alignas(64) Lanes<float> inverse_start_;  // of what each of them carried at its light
  HitState hits_;
  alignas(64) Lanes<std::uint32_t> pixel_hash_, reversed_sample_;  // of the path in slot i
  ShadowQueue connections_;                                        // from surfaces to the lens
  alignas(64) Lanes<float> film_x_, film_y_;                       // where they land
};

}  // namespace tessera::render::TESSERA_ISA
