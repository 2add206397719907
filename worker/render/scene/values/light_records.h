// How many lights a message of one makes.
#pragma once

#include "tessera/v1/light.pb.h"
#include "wire/sky_light.h"

namespace tessera::render {

/// Records that LightBuilder makes of a light without a shape, one after the other: 2 of a sky with a sun
/// (first the sky and the ground, then the sun), else 1.
inline int records_of(const v1::Light& light) {
  return light.has_sky() && wire::has_sun(light.sky()) ? 2 : 1;
}

}  // namespace tessera::render
