// Ghosts of lights, by light tracing: a place of the lens is lit by a sampled light, and what it sends there
// is followed over two reflections to the film. That finds lamps and the sun, which rays from the film hardly
// meet; what those meet is weighed against it by the power heuristic [Veach 1997].
#pragma once

#include <cstdint>
#include <stop_token>

#include "render/integrator/integrator.h"
#include "render/transport/vertex/sensor_joins.h"

namespace tessera::render::TESSERA_ISA {

/// Whether algorithms that work in passes are to add such light.
bool sends_light_into_lens(const SceneTables& scene);

class GhostLight {
 public:
  explicit GhostLight(const IntegratorContext& context)
      : scene_(context.scene), seed_(context.seed), joins_(context) {}

  /// Sends as much light into the lens as the film has pixels, wherever it lands: that of one pass. False
  /// when stopped.
  bool trace(std::uint32_t pass, Film& film, std::stop_token stop);

 private:
  void send(UInt index, std::uint32_t pass, const FilmRect& rect, Mask active);

  const SceneTables& scene_;
  const std::uint64_t seed_;
  SensorJoins joins_;
};

}  // namespace tessera::render::TESSERA_ISA
