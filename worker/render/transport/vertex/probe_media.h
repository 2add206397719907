// The media around probes: each reading begins in that of its own place.
#pragma once

#include <memory>

#include "render/integrator/integrator.h"
#include "render/transport/vertex/path_state.h"

namespace tessera::render::TESSERA_ISA {

class ProbeMedia {
 public:
  explicit ProbeMedia(const IntegratorContext& context) : context_(context) {}

  /// Puts paths that begin at probes into the media around their origins.
  void enter(WidePath& paths, Mask active);

 private:
  const IntegratorContext context_;
  ConnectionQueue ways_;
  HitState hits_;
  alignas(64) Lanes<std::int32_t> media_;
};

/// Null where all places that the sensor's paths begin at are in its own medium: where it has no probes, or
/// the scene no borders of media.
std::unique_ptr<ProbeMedia> make_probe_media(const IntegratorContext& context);

}  // namespace tessera::render::TESSERA_ISA
