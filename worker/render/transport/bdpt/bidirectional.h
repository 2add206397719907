// Bidirectional path tracing: a subpath from the eye and one from a light for each sample, and every vertex
// of the one joined to every vertex of the other, all weighed against each other [Lafortune & Willems 1993;
// Veach & Guibas 1994].
//
// A way to make a path is (s, t): s of its vertices are from the light, t from the eye, the camera's among
// them. t = 1 lands anywhere on the film, so work is done in passes; s = 0 is a path that hits a light by
// itself, s = 1 is light sampling. A batch of samples advances as a wavefront: first all subpaths from
// lights, event by event, then those from the eye, whose every vertex is joined to what is kept of the
// light's in its lane.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>

#include "render/integrator/integrator.h"
#include "render/integrator/stage_timer.h"
#include "render/transport/bdpt/frontier.h"
#include "render/transport/bdpt/light_subpaths.h"
#include "render/transport/bdpt/strategy.h"
#include "render/transport/vertex/sample_batch.h"
#include "render/transport/vertex/shadow_layers.h"
#include "render/transport/vertex/transit.h"

namespace tessera::render::TESSERA_ISA {

class Merging;
struct EyeVertex;

class Bidirectional final : public Integrator {
 public:
  /// With `merging`, vertices are merged as well: vertex connection and merging.
  explicit Bidirectional(const IntegratorContext& context, StrategyFilter filter = {},
                         std::unique_ptr<Merging> merging = nullptr);
  ~Bidirectional() override;

  bool render(SampleSource& work, Film& film, std::stop_token stop) override;

 private:
  struct Event;
  /// Traces subpaths from the lights of all the film's pixels but these: they may land anywhere.
  bool trace_lights(std::uint32_t pass, const FilmRect& but, Film& film, std::stop_token stop);
  /// Vertices that subpaths from lights have and merging catches, in the mean.
  double photons_a_path();
  void advance(int depth);
  void shade(int depth);
  void shade_packet(int packet, int depth);

  // The steps of shade(), for 16 paths.
  Float weight_of_sky(const Event& e, std::int32_t light, Mask missed) const;
  void add_environment(const Event& e, Mask missed);
  void add_emission(const Event& e, Mask hit);
  EyeVertex eye_vertex(const Event& e) const;
  void sample_one_light(const Event& e, Mask wanted);
  void join_to_light_subpaths(const Event& e, Mask wanted);
  void join(const Event& e, const LightVertex& y, int event, Mask wanted);
  void merge(const Event& e, Mask wanted);
  void scatter(const Event& e, Mask hit);
  /// Layers, as bits, of what is found by joining the vertex to `s` vertices from the light.
  Int layers_of_way(const Event& e, int s) const;
  /// Adds light, and what it would be with a weight of 1, to those of these layers that are of lights that
  /// are met.
  void add_to_layers_of_hits(const Event& e, Spectrum light, Spectrum unweighted, Int light_number,
                             Mask lanes);
  void look_for_shadow(const Event& e, WideConnection ray, Spectrum light, Int state, Int light_number,
                       Mask shines);
  /// The state of the layers' automaton behind the vertex, whose light comes from `wi`.
  Int state_after_join(const Event& e, Vec3 wi, Mask active) const;
  void queue(const Event& e, WideConnection ray, std::uint32_t salt, Mask shines);
  void trace_joins(int depth);

  const SceneTables& scene_;
  const std::uint64_t sampler_seed_;
  RenderStats& stats_;
  const StrategyFilter filter_;
  SampleBatch batch_;
  LightSubpaths lights_;
  const std::unique_ptr<Merging> merging_;  // may be none
  PassShare shared_;                        // more than the times of lights where passes are merged
  Frontier frontier_;
  WeightState weights_;
  ConnectionQueue joins_;  // rays to lights and to vertices of the other subpath
  Transit transit_;        // volumetric scenes only, like the next
  HitState join_hits_;
  SampleKeys other_keys_;
  std::optional<StageTimer> shading_;
  const std::unique_ptr<ShadowLayers> shadow_layers_;  // null where no layer is of shadows
};

}  // namespace tessera::render::TESSERA_ISA
