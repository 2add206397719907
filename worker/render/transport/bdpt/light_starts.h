// Where a batch's subpaths from lights begin: what their first vertices have to know.
#pragma once

#include "render/integrator/integrator.h"
#include "render/transport/bdpt/frontier.h"
#include "render/transport/vertex/light_start.h"
#include "render/transport/vertex/path_state.h"

namespace tessera::render::TESSERA_ISA {

class LightStarts {
 public:
  explicit LightStarts(const IntegratorContext& context) : context_(context), scene_(context.scene) {}

  void clear() { ways_.size = 0; }
  /// Remembers a packet's, and completes its paths.
  void add(int packet, LightStart& start);
  /// Puts paths into the media that they begin in, once all are at their entries of `frontier`.
  void enter_media(Frontier& frontier);

  /// Sums at the first vertices of a packet's subpaths.
  PartialWeights first_weights(int packet, const Vertex& v, Mask hit) const;

 private:
  const IntegratorContext context_;
  const SceneTables& scene_;
  // Indexed by slot
  alignas(64) Lanes<std::int32_t> light_;
  Vec3Lanes point_, normal_;
  // Volumetric scenes only
  ConnectionQueue ways_;  // rays that find the lights' media
  alignas(64) Lanes<std::int32_t> media_;
};

}  // namespace tessera::render::TESSERA_ISA
