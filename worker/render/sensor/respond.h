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
  /// `response` is SensitivityTable::light, or matter for reflectances.
  TESSERA_INLINE Channels(const SensitivityTable& sensor, const std::vector<float>& response,
                          const Wavelengths& wavelengths)
      : response_(lane_response(sensor, response, wavelengths)) {}

  /// A channel of light whose lanes are lane(0), lane(1) and so on.
  template <class Lane>
  TESSERA_INLINE Float of(int channel, Lane&& lane) const {
    Float sum = lane(0) * response_.color[0].c[channel];
    for (int i = 1; i < kSpectrumLanes; ++i) sum = fma(lane(i), response_.color[i].c[channel], sum);
    return sum;
  }
  /// The density of radiance, per nanometre, that a lane of one stands for.
  TESSERA_INLINE Float weight(int lane) const { return response_.weight[lane]; }

 private:
  LaneResponse response_;
#else
  template <class Lane>
  TESSERA_INLINE auto of(int channel, Lane&& lane) const {
    return lane(channel);
  }
#endif
};

/// The channels of light of these wavelengths, and of reflectances in the light that is white to the sensor.
TESSERA_INLINE Channels channels_of_light(const Response& response, const Wavelengths& wavelengths) {
#ifdef TESSERA_SPECTRAL
  return {response.sensitivity, response.sensitivity.light, wavelengths};
#else
  return {};
#endif
}
TESSERA_INLINE Channels channels_of_matter(const Response& response, const Wavelengths& wavelengths) {
#ifdef TESSERA_SPECTRAL
  return {response.sensitivity, response.sensitivity.matter, wavelengths};
#else
  return {};
#endif
}

#ifdef TESSERA_SPECTRAL
/// The band of the film that each wavelength is in, -1 where there is none, and the mean radiance of that
/// band, before the exposure, that light of one stands for.
struct BandShare {
  Int band;
  Float weight;
};
TESSERA_INLINE BandShare band_share(const SensitivityTable& sensor, const Wavelengths& wavelengths,
                                    const Channels& channels, int lane) {
  const Float place = (wavelengths.c[lane] - sensor.first_band_nm) * sensor.bands_per_nm;
  const Mask inside = (place >= 0.0f) & (place < static_cast<float>(sensor.bands));
  return {select(inside, to_int(place), Int(-1)), channels.weight(lane) * sensor.bands_per_nm};
}
#endif

/// Light, or a channel of it, as the sensor is exposed to it.
TESSERA_INLINE Float exposed(const Response& response, Float light) { return light * response.exposure; }

}  // namespace tessera::render::TESSERA_ISA
