// The path tracer as a wavefront: a batch of paths advances one scattering event at a time, 16 paths wide
// [Laine, Karras & Aila 2013].
#pragma once

#include <memory>
#include <stop_token>
#include <vector>

#include "render/integrator/integrator.h"
#include "render/integrator/stage_timer.h"
#include "render/transport/path/path_reuse.h"
#include "render/transport/vertex/path_observer.h"
#include "render/transport/vertex/sample_batch.h"
#include "render/transport/vertex/transit.h"

namespace tessera::render::TESSERA_ISA {

/// Algorithms that observe its paths, or begin them elsewhere, are derived from it.
class Wavefront : public Integrator {
 public:
  explicit Wavefront(const IntegratorContext& context) : Wavefront(context, context.scene.max_depth) {}
  /// `max_depth`: scattering events on a path; 0 finds what emits, seen from the eye.
  Wavefront(const IntegratorContext& context, std::int32_t max_depth);

  bool render(SampleSource& work, Film& film, std::stop_token stop) override;

 protected:
  /// Tells it of all paths; observers are told in the order in which they are added.
  void add(PathObserver& observer) { observers_.push_back(&observer); }
  /// Lets it choose directions, and tells it of all paths.
  void steer(Steering& steering) {
    steering_ = &steering;
    add(steering);
  }
  /// Follows the first `n` paths to their ends; their next event is that of `depth`.
  void trace(int depth, int n);

  const IntegratorContext context_;
  const SceneTables& scene_;
  RenderStats& stats_;
  SampleBatch batch_;
  PathState paths_;

 private:
  void advance(int depth);
  void shade(int depth);
  /// Copies paths and hits into sorted_, those of one shading group together.
  void sort_by_group();
  void trace_to_lights(int depth);

  // The steps of shade(), for 16 paths; see shade.cpp.
  void add_environment(const Encounter& e);
  void add_emission(const Encounter& e, Mask hit);
  void sample_one_light(const Encounter& e);
  void scatter_path(const Encounter& e, int& kept);

  /// Paths and what they met in the order in which they are shaded.
  struct SortedState {
    PathState paths;
    HitState hits;
    alignas(64) Lanes<std::int32_t> group;  // group of each entry of the unsorted state
    alignas(64) Lanes<std::int32_t> order;  // the order in which those entries are shaded
  };

  ShadingTimer shading_timer_{stats_.times};
  const std::int32_t max_depth_;
  int alive_ = 0;
  HitState hits_;
  SortedState sorted_;  // scenes with shading groups only
  ConnectionQueue shadows_;
  Transit transit_;               // volumetric scenes only
  Steering* steering_ = nullptr;  // null: paths go as BSDFs have it
  std::vector<PathObserver*> observers_;
  const std::unique_ptr<PathObserver> layers_, straight_shadows_;  // null where there are none
  std::unique_ptr<PathReuse> reuse_;                               // null where neighbours do not share light
};

}  // namespace tessera::render::TESSERA_ISA
