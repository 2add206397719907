#include "render/transport/vertex/probe_media.h"

#include <algorithm>

#include "render/transport/vertex/medium_at.h"

namespace tessera::render::TESSERA_ISA {

void ProbeMedia::enter(WidePath& paths, Mask active) {
  const SceneTables& scene = context_.scene;
  const WideConnection ways = way_from_sensor(scene, paths.origin, paths.time, Int::iota(0));
  ways_.size = append(scene, ways, active, ways_, 0);
  paths.medium.store(media_);
  find_media(context_, ways_, hits_, media_);
  paths.medium = Int::load(media_);
}

std::unique_ptr<ProbeMedia> make_probe_media(const IntegratorContext& context) {
  const SceneTables& scene = context.scene;
  if (!scene.sensor.probes || scene.media.media.empty()) return nullptr;
  const bool any_border = std::ranges::any_of(
      scene.shapes.shapes, [](const ShapeRecord& shape) { return (shape.flags & kMediumBorder) != 0; });
  return any_border ? std::make_unique<ProbeMedia>(context) : nullptr;
}

}  // namespace tessera::render::TESSERA_ISA
