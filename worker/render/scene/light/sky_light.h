// How many lights a message of daylight makes.
#pragma once

#include "tessera/v1/light.pb.h"

namespace tessera::render {

/// Records that LightBuilder makes of a light without a shape, one after the other: 2 of a sky with a sun
/// (first the sky and the ground, then the sun), else 1.
int records_of(const v1::Light& light);

/// Whether rays never meet the sun of a sky.
bool has_parallel_sun(const v1::SkyLight& light);

}  // namespace tessera::render
