// Suns of daylight.
#pragma once

#include "tessera/v1/light.pb.h"

namespace tessera::render {

/// Whether rays never meet the sun of a sky.
bool has_parallel_sun(const v1::SkyLight& light);

}  // namespace tessera::render
