// Radiosity seen: patches as they are shown, or by a final gather.
#pragma once

#include "render/integrator/integrator.h"
#include "render/textbook/radiosity/phases.h"
#include "render/transport/vertex/encounter.h"

namespace tessera::render::TESSERA_ISA {

/// Shows what camera rays meet as bright as its patch. With a final gather [Reichert 1992] it is lit by
/// lights directly, and by patches over one ray a sample; where that ends nearer than patches can tell, the
/// path goes on.
class Radiosity final : public Integrator {
 public:
  explicit Radiosity(const IntegratorContext& context);

  bool render(SampleSource& work, Film& film, std::stop_token stop) override;

 private:
  void meet(int depth);
  void add_emission(const Encounter& e);
  Mask add_patches(const Encounter& e, Mask wanted, bool seen_directly);
  void add_light(const Encounter& e, Mask wanted);
  void scatter(const Encounter& e, Mask wanted, int& kept);

  const SceneTables& scene_;
  RenderStats& stats_;
  const radiosity::Solved& solved_;
  SampleBatch batch_;
  PathState paths_;
  int alive_ = 0;
  HitState hits_;
  ConnectionQueue shadows_;
};

}  // namespace tessera::render::TESSERA_ISA
