// Light that passes clear glass unbent (RenderSettings.glass_shadows), as paths weigh it that pass the glass.
#pragma once

#include "render/transport/vertex/path_observer.h"

namespace tessera::render::TESSERA_ISA {

/// Keeps the density and the receiver of paths that pass clear glass, as rays to lights do: light behind it
/// is weighed as if it were not there. Within glass a negative density marks an odd number of reflections:
/// such a path leaves as if the glass as a whole had mirrored it, and light samples do not find its light.
class StraightShadows final : public PathObserver {
 public:
  explicit StraightShadows(const SceneTables& scene) : scene_(scene) {}

  void scattered(const Encounter& e, Scattering& s) override;

 private:
  const SceneTables& scene_;
};

}  // namespace tessera::render::TESSERA_ISA
