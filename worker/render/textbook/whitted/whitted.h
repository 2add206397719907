// Ray tracing as textbooks have it: at each hit, shadow rays to all lights, and a ray for each direction of
// perfect reflection and refraction [Whitted 1980]. Light between surfaces that are neither is left out.
#pragma once

#include <algorithm>
#include <memory>
#include <stop_token>
#include <vector>

#include "render/integrator/integrator.h"
#include "render/transport/vertex/layer_observer.h"
#include "render/transport/vertex/sample_batch.h"

namespace tessera::render::TESSERA_ISA {

class Whitted final : public Integrator {
 public:
  enum class Mirrors { kFollowed, kBlack };

  explicit Whitted(const IntegratorContext& context)
      : Whitted(context, context.scene.max_depth, Mirrors::kFollowed) {}
  /// `max_depth`: hits on a path that are lit, kDeepest at most. Ray casting is one, with black mirrors.
  Whitted(const IntegratorContext& context, std::int32_t max_depth, Mirrors mirrors)
      : scene_(context.scene),
        stats_(context.stats),
        max_depth_(std::min(max_depth, kDeepest)),
        follows_(mirrors == Mirrors::kFollowed),
        batch_(context),
        layers_(make_layer_observer(context, batch_)) {
    if (layers_) observers_.push_back(layers_.get());
    encounters_.reserve(kBatch / kWidth);
  }

  bool render(SampleSource& work, Film& film, std::stop_token stop) override;

 private:
  /// Between mirrors that lose nothing only this ends the recursion, each level of which keeps 170 KB.
  static constexpr std::int32_t kDeepest = 100;
  /// The rays that one level of the recursion sends to the next.
  struct Level {
    PathState reflected, refracted;
  };

  /// Adds the radiance along the first `n` rays to their samples. False when it was stopped before the end.
  bool trace(const PathState& rays, int n, int depth, const std::stop_token& stop);
  void find_points(const PathState& rays, int n, int depth);
  void add_emission(const Encounter& e);
  void add_light(std::int32_t number, int depth);
  void follow(Level& next, int& reflected, int& refracted) const;

  const SceneTables& scene_;
  RenderStats& stats_;
  const std::int32_t max_depth_;
  const bool follows_;  // reflected and refracted rays
  SampleBatch batch_;
  const std::unique_ptr<PathObserver> layers_;  // null where there are none
  std::vector<PathObserver*> observers_;
  PathState camera_rays_;
  HitState hits_;
  std::vector<Encounter> encounters_;  // encounters, one for each packet of rays
  ConnectionQueue shadows_;
  std::vector<std::unique_ptr<Level>> levels_;
};

}  // namespace tessera::render::TESSERA_ISA
