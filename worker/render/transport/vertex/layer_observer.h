// Layers of the light that paths from the eye bring, and of the shadows that they see.
#pragma once

#include <memory>

#include "render/transport/vertex/path_observer.h"
#include "render/transport/vertex/shadow_layers.h"

namespace tessera::render::TESSERA_ISA {

/// Keeps the automaton's states of paths, and gives what they bring to its layers (layers.h).
class LayerObserver final : public PathObserver {
 public:
  LayerObserver(const IntegratorContext& context, SampleBatch& batch)
      : scene_(context.scene), stats_(context.stats), batch_(batch), shadows_(make_shadow_layers(context)) {}

  void emitted(const Encounter& e, MetLight& light) override;
  void lit(const Encounter& e, SampledLight& light) override;
  void scattered(const Encounter& e, Scattering& s) override;
  void all_scattered(int depth) override;

 private:
  Int state_behind(const Encounter& e, Vec3 wi, Mask lanes) const;
  void look_for_shadow(const Encounter& e, const SampledLight& light, Int state, Mask shines);
  void look_for_shadow_of_sky(const Encounter& e, const Scattering& s, Mask lanes);

  const SceneTables& scene_;
  RenderStats& stats_;
  SampleBatch& batch_;
  const std::unique_ptr<ShadowLayers> shadows_;  // null where no layer is of shadows
};

/// Null where a job has no layers.
std::unique_ptr<LayerObserver> make_layer_observer(const IntegratorContext& context, SampleBatch& batch);

}  // namespace tessera::render::TESSERA_ISA
