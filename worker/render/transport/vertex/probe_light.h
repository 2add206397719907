// Light that shines straight on probes, by light sampling. Rays of the sensor find lamps and the sky as well,
// and are weighed against it by the power heuristic [Veach 1997]; lights without a surface they never meet.
#pragma once

#include "render/sampling/sampler.h"
#include "render/transport/vertex/path_state.h"

namespace tessera::render::TESSERA_ISA {

/// Appends to `queue` the light that reaches the pixels (x, y), from which these 16 paths begin; a path's
/// normal is the probe's axis where it begins, and becomes what Receiver::normal asks for.
void append_probe_light(const SceneTables& scene, UInt x, UInt y, const Sampler& sampler, UInt key,
                        Mask active, WidePath& path, ConnectionQueue& queue);

}  // namespace tessera::render::TESSERA_ISA
