// Radiosity seen: patches as they are shown, or by a final gather.
#pragma once

#include "render/integrator/integrator.h"
#include "render/integrator/radiosity/phases.h"
#include "render/integrator/vertex/path_state.h"
#include "render/integrator/vertex/sample_batch.h"
#include "render/integrator/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

/// Shows what camera rays meet as bright as its patch. With a final gather [Reichert 1992] it is lit by
/// lights directly, and by patches over one ray a sample; where that ends nearer than patches can tell, the
/// path goes on.
class Radiosity final : public Integrator {
 public:
  explicit Radiosity(const IntegratorContext& context);

  bool render(SampleSource& work, Film& film, std::stop_token stop) override;

 private:
  struct Point;

  void meet(int depth);
  void add_emission(const Point& point, Mask active);
  Mask add_patches(const Point& point, Mask wanted, bool seen_directly);
  void add_light(const Point& point, Mask wanted, int depth);
  void scatter(const Point& point, Mask wanted, int depth, int& kept);
  Vec2 random(const Point& point, int pair) const;

  const SceneTables& scene_;
  const RayQuery& rays_;
  RenderStats& stats_;
  const radiosity::Solved& solved_;
  SampleBatch batch_;
  PathState paths_;
  int alive_ = 0;
  HitState hits_;
  ConnectionQueue shadows_;
};

}  // namespace tessera::render::TESSERA_ISA
