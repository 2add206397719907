// Layers of shadows: light that something is in the way of.
#pragma once

#include <memory>

#include "render/integrator/integrator.h"
#include "render/transport/vertex/sample_batch.h"
#include "render/transport/vertex/transit.h"

namespace tessera::render::TESSERA_ISA {

/// Rays to lights that wait to be traced, apart from those that bring the picture's light. What does not
/// arrive is their light: all of it, or what media and surfaces on the way take.
class ShadowLayers {
 public:
  explicit ShadowLayers(const IntegratorContext& context)
      : scene_(context.scene), rays_(context.rays), stats_(context.stats), transit_(context) {}

  /// A ray has its light as its contribution, the layers of shadows that this is of, and a slot of the batch.
  /// `event` is that of the vertex where it begins.
  void add(const WideConnection& ray, Mask shines, SampleBatch& batch, int event);
  void trace(SampleBatch& batch, int event);

 private:
  const SceneTables& scene_;
  const RayQuery& rays_;
  RenderStats& stats_;
  ConnectionQueue waiting_;
  Transit transit_;  // volumetric scenes only, like the next
  HitState hits_;
};

/// Null where no layer is of shadows.
inline std::unique_ptr<ShadowLayers> make_shadow_layers(const IntegratorContext& context) {
  return context.scene.layers.has_shadows ? std::make_unique<ShadowLayers>(context) : nullptr;
}

}  // namespace tessera::render::TESSERA_ISA
