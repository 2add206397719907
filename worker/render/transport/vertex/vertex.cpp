#include "render/transport/vertex/vertex.h"

#include "render/transport/vertex/passing.h"

namespace tessera::render::TESSERA_ISA {

void put_into_medium(Vec3 p, Mask lanes, Vertex& v) {
  v.surface.p = select(lanes, p, v.surface.p);
  v.at.flags = select(lanes, Int(0), v.at.flags);
  v.at.traits = select(lanes, Int(0), v.at.traits);
}

void open_surface(const SceneTables& scene, Float u, Mask partly, Vertex& v) {
  const Mask open = partly & (u >= opacity_of(scene, v.at.material, v.surface, partly));
  v.at.kind = select(open, Int(static_cast<std::int32_t>(kNoSurface)), v.at.kind);
  v.at.flags = select(open, Int(kAllDelta), v.at.flags);
  v.at.traits = select(open, Int(0), v.at.traits);
  v.at.lambertian = v.at.lambertian && none(open);
}

}  // namespace tessera::render::TESSERA_ISA
