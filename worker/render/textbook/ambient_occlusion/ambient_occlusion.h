// Ambient occlusion: how much of the sky each point sees, the cosine-weighted share of directions in which
// nothing is near [Landis 2002]. Neither lights nor materials matter.
#pragma once

#include <stop_token>

#include "render/integrator/integrator.h"
#include "render/transport/vertex/path_state.h"
#include "render/transport/vertex/sample_batch.h"
#include "render/transport/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

class AmbientOcclusion final : public Integrator {
 public:
  explicit AmbientOcclusion(const IntegratorContext& context)
      : scene_(context.scene), stats_(context.stats), batch_(context) {}

  bool render(SampleSource& work, Film& film, std::stop_token stop) override;

 private:
  /// Sends a ray from each point that was hit, in a direction drawn by its cosine; it carries white, as
  /// daylight is.
  void look_around();
  void trace();

  const SceneTables& scene_;
  RenderStats& stats_;
  SampleBatch batch_;
  PathState camera_rays_;
  HitState hits_;
  ConnectionQueue around_;
};

}  // namespace tessera::render::TESSERA_ISA
