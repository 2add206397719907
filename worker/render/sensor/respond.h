// The channels of light that reaches a sensor, as its Response says.
#pragma once

#include "render/color/spectra.h"
#include "render/sensor/response.h"

namespace tessera::render::TESSERA_ISA {

/// How many channels a picture's colour has.
inline constexpr int kResponseChannels = kBands;

/// From the lanes of light to channels, before the exposure.
class Channels {
 public:
  Channels() = default;
#ifdef TESSERA_SPECTRAL
  /// `response` is SpectralTables::response, or daylight_response for reflectances.
  TESSERA_INLINE Channels(const SpectralTables& tables, const std::vector<float>& response,
                          const Wavelengths& wavelengths)
      : response_(lane_response(tables, response, wavelengths)) {}

  /// A channel of light whose lanes are lane(0), lane(1) and so on.
  template <class Lane>
  TESSERA_INLINE Float of(int channel, Lane&& lane) const {
    Float sum = lane(0) * response_.lane[0].c[channel];
    for (int i = 1; i < kSpectrumLanes; ++i) sum = fma(lane(i), response_.lane[i].c[channel], sum);
    return sum;
  }

 private:
  LaneResponse response_;
#else
  template <class Lane>
  TESSERA_INLINE auto of(int channel, Lane&& lane) const {
    return lane(channel);
  }
#endif
};

/// The channels of light of these wavelengths, and of reflectances in daylight.
TESSERA_INLINE Channels channels_of_light(const SpectralTables* tables, const Wavelengths& wavelengths) {
#ifdef TESSERA_SPECTRAL
  return {*tables, tables->response, wavelengths};
#else
  return {};
#endif
}
TESSERA_INLINE Channels channels_of_matter(const SpectralTables* tables, const Wavelengths& wavelengths) {
#ifdef TESSERA_SPECTRAL
  return {*tables, tables->daylight_response, wavelengths};
#else
  return {};
#endif
}

/// Light, or a channel of it, as the sensor is exposed to it.
TESSERA_INLINE Float exposed(const Response& response, Float light) { return light * response.exposure; }

}  // namespace tessera::render::TESSERA_ISA
