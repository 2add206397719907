// Ray tracing as textbooks have it: at each hit, shadow rays to all lights, and a ray for each direction of
// perfect reflection and refraction [Whitted 1980]. Light between surfaces that are neither is left out.
#pragma once

#include <algorithm>
#include <memory>
#include <stop_token>
#include <vector>

#include "render/integrator/integrator.h"
#include "render/integrator/vertex/path_state.h"
#include "render/integrator/vertex/sample_batch.h"
#include "render/integrator/vertex/shadow_layers.h"
#include "render/integrator/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

class Whitted final : public Integrator {
 public:
  enum class Mirrors { kFollowed, kBlack };

  explicit Whitted(const IntegratorContext& context)
      : Whitted(context, context.scene.max_depth, Mirrors::kFollowed) {}
  /// `max_depth`: hits on a path that are lit, kDeepest at most. Ray casting is one, with black mirrors.
  Whitted(const IntegratorContext& context, std::int32_t max_depth, Mirrors mirrors)
      : scene_(context.scene),
        rays_(context.rays),
        stats_(context.stats),
        max_depth_(std::min(max_depth, kDeepest)),
        follows_(mirrors == Mirrors::kFollowed),
        batch_(context),
        shadow_layers_(make_shadow_layers(context)),
        points_(kBatch / kWidth) {}

  bool render(SampleSource& work, Film& film, std::stop_token stop) override;

 private:
  /// Sixteen points that rays have hit.
  struct Point {
    WidePath path;
    Vertex vertex;
    Mask hit = Mask::none();
  };
  /// Between mirrors that lose nothing only this ends the recursion, each level of which keeps 170 KB.
  static constexpr std::int32_t kDeepest = 100;
  /// The rays that one level of the recursion sends to the next.
  struct Level {
    PathState reflected, refracted;
  };

  /// A pair of random numbers of the points' samples.
  Vec2 random(const Point& point, int pair) const {
    return batch_.sampler(point.path.slot, point.hit).get_2d(pair);
  }

  /// Adds the radiance along the first `n` rays to their samples. False when it was stopped before the end.
  bool trace(const PathState& rays, int n, int depth, const std::stop_token& stop);
  void find_points(const PathState& rays, int n, int depth);
  void add_emission(const Point& point, Mask active);
  void add_light(std::int32_t light, int depth);
  void follow(int depth, Level& next, int& reflected, int& refracted) const;

  const SceneTables& scene_;
  const RayQuery& rays_;
  RenderStats& stats_;
  const std::int32_t max_depth_;
  const bool follows_;  // reflected and refracted rays
  SampleBatch batch_;
  const std::unique_ptr<ShadowLayers> shadow_layers_;  // where some layer is of shadows
  PathState camera_rays_;
  HitState hits_;
  std::vector<Point> points_;  // of the rays that are traced
  int packets_ = 0;            // of those
  ConnectionQueue shadows_;
  std::vector<std::unique_ptr<Level>> levels_;
};

}  // namespace tessera::render::TESSERA_ISA
