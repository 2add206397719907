// One event of subpaths from lights that are weighed against other ways: what algorithms share that join both
// ends.
#pragma once

#include "render/transport/vertex/path_state.h"
#include "render/transport/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

/// Where subpaths go from a vertex.
struct LightStep {
  WidePath next;
  Float pdf;       // density of that direction, by solid angle
  Float back_pdf;  // density of the way back, for paths from the eye
  Mask specular, alive;
};

/// `path` arrived at `v`; what leaves is what paths from the eye would find, over the density of this side.
/// Nothing ends at random.
LightStep step_from_light(const SceneTables& scene, const Vertex& v, const WidePath& path, Float u_lobe,
                          Vec2 u, Mask hit);

}  // namespace tessera::render::TESSERA_ISA
