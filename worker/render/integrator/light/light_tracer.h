// Light tracing: paths begin at the lights, and every point that they are scattered at is joined to the
// camera [Arvo 1986; Dutre, Lafortune & Willems 1993]. What it finds easily, caustics above all, is what path
// tracing hardly finds, and the other way round: surfaces seen in a mirror stay black.
//
// A pass traces as many paths as the film has pixels; they may land anywhere on it. Lights that the camera
// sees directly are added by camera rays.
#pragma once

#include <stop_token>

#include "render/integrator/integrator.h"
#include "render/integrator/path/wavefront.h"
#include "render/integrator/stage_timer.h"
#include "render/integrator/vertex/camera_joins.h"
#include "render/integrator/vertex/path_state.h"
#include "render/integrator/vertex/sample_keys.h"

namespace tessera::render::TESSERA_ISA {

class LightTracer final : public Integrator {
 public:
  explicit LightTracer(const IntegratorContext& context)
      : scene_(context.scene),
        rays_(context.rays),
        seed_(context.seed),
        stats_(context.stats),
        eye_(context, 0),
        joins_(context) {}

  bool render(SampleSource& work, Film& film, std::stop_token stop) override;

 private:
  /// Times of rays as a query wants them.
  const float* times_of(const Lanes<float>& times) const { return scene_.any_motion ? times : nullptr; }
  void start_paths(std::int32_t first, std::int32_t count, std::uint32_t pass);
  void advance(int depth, Film& film);
  void intersect();
  void shade(int depth, const FilmRect& rect);
  struct Event;
  void join_to_camera(const Event& e, Mask hit, const FilmRect& rect);
  void scatter_paths(const Event& e, Mask hit, int& kept);

  const SceneTables& scene_;
  const RayQuery& rays_;
  const std::uint64_t seed_;
  RenderStats& stats_;
  Wavefront eye_;  // finds the lights that are seen directly
  int alive_ = 0;
  PathState paths_;
  HitState hits_;
  SampleKeys keys_;
  CameraJoins joins_;
};

}  // namespace tessera::render::TESSERA_ISA
