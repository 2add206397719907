// The channels of light that reaches a sensor, as its Response says.
#pragma once

#include "render/color/spectrum.h"
#include "render/sensor/response.h"

namespace tessera::render::TESSERA_ISA {

/// How many channels a picture's colour has.
inline constexpr int kResponseChannels = kBands;

/// A channel of light whose lanes are lane(0), lane(1) and so on, before the exposure.
template <class Lane>
TESSERA_INLINE auto channel_of(int channel, Lane&& lane) {
  return band_mean(channel, lane);
}

/// Light, or a channel of it, as the sensor is exposed to it.
TESSERA_INLINE Float exposed(const Response& response, Float light) { return light * response.exposure; }

}  // namespace tessera::render::TESSERA_ISA
