// The path tracer as a wavefront: a batch of paths advances one scattering event at a time, 16 paths wide
// [Laine, Karras & Aila 2013].
#pragma once

#include <memory>
#include <stop_token>

#include "render/integrator/guide/guide_recorder.h"
#include "render/integrator/integrator.h"
#include "render/integrator/path/path_reuse.h"
#include "render/integrator/stage_timer.h"
#include "render/integrator/vertex/path_state.h"
#include "render/integrator/vertex/sample_batch.h"
#include "render/integrator/vertex/shadow_layers.h"
#include "render/integrator/vertex/transit.h"
#include "render/integrator/vertex/vertex.h"
#include "render/light/light.h"

namespace tessera::render::TESSERA_ISA {

/// Algorithms that end its paths sooner, or begin them elsewhere, are derived from it.
class Wavefront : public Integrator {
 public:
  explicit Wavefront(const IntegratorContext& context) : Wavefront(context, context.scene.max_depth) {}
  /// `max_depth`: scattering events on a path; 0 finds what emits, seen from the eye.
  Wavefront(const IntegratorContext& context, std::int32_t max_depth)
      : context_(context),
        scene_(context.scene),
        stats_(context.stats),
        batch_(context),
        rays_(context.rays),
        max_depth_(max_depth),
        transit_(context),
        shadow_layers_(make_shadow_layers(context)) {}

  bool render(SampleSource& work, Film& film, std::stop_token stop) override;

 protected:
  /// Adds the light of those lanes of `hit` that are known, but for what lamps bring to them directly, and
  /// returns them: their paths end here. `t` is the length of the latest segment.
  virtual Mask settle(WidePath&, const Vertex&, Float, Mask, int) { return Mask::none(); }
  /// Follows the first `n` paths to their ends; their next event is that of `depth`.
  void trace(int depth, int n);

  const IntegratorContext context_;
  const SceneTables& scene_;
  RenderStats& stats_;
  SampleBatch batch_;
  PathState paths_;
  const GuideField* guide_ = nullptr;  // of directions; null: paths go as BSDFs have it
  GuideRecorder* recorder_ = nullptr;  // of what paths find; may be null

 private:
  void advance(int depth);
  void intersect(int depth);
  void shade(int depth);
  /// Copies paths and hits into sorted_, those of one shading group together.
  void sort_by_group();
  void trace_to_lights(int depth);
  void trace_shadow_rays();
  /// Times of rays as a query wants them.
  const float* times_of(const Lanes<float>& times) const { return scene_.any_motion ? times : nullptr; }

  // The steps of shade(), for 16 paths; see shade.cpp.
  struct Event;
  void find_guide(Event& e, Mask events, int depth);
  void add_environment(const Event& e, Mask missed, int depth);
  void add_emission(const Event& e, Mask hit, int depth);
  void sample_one_light(const Event& e, Mask events, Mask settled, int depth);
  void keep_reference(const Event& e, const BsdfSample& bsdf, Mask events, WidePath& next) const;
  void scatter_path(const Event& e, Mask events, int depth, int& kept);
  /// Whether paths may share what they find at this event.
  bool reuses(int depth) const { return reuse_ && reuse_->follows(depth); }
  /// Whether second surfaces share the light of lamps and of the sky: paths find each by one density alone.
  bool shares_lamps() const { return !scene_.straight_shadows; }
  bool shares_sky() const { return shares_lamps() && scene_.lights.infinite_lights.size() <= 1; }
  Int state_behind(const Event& e, Vec3 wi, int depth, Mask lanes) const;
  void look_for_shadow(const Event& e, WideConnection ray, Int state, Int light, Float weight, int depth,
                       Mask shines);
  void look_for_shadow_of_sky(const Event& e, const BsdfSample& bsdf, Spectrum beta, int depth, Mask lanes);

  /// Paths and what they met in the order in which they are shaded.
  struct SortedState {
    PathState paths;
    HitState hits;
    alignas(64) Lanes<std::int32_t> group;  // of each entry of the unsorted state
    alignas(64) Lanes<std::int32_t> order;  // of those entries
  };

  const RayQuery& rays_;
  ShadingTimer shading_timer_{stats_.times};
  const std::int32_t max_depth_;
  int alive_ = 0;
  HitState hits_;
  SortedState sorted_;  // scenes with shading groups only
  ConnectionQueue shadows_;
  Transit transit_;                                    // volumetric scenes only
  const std::unique_ptr<ShadowLayers> shadow_layers_;  // where some layer is of shadows
  std::unique_ptr<PathReuse> reuse_;                   // where neighbours share light
};

}  // namespace tessera::render::TESSERA_ISA
