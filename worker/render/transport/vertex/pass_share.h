// Things that all paths of a pass have in common, where what lights have lit is looked for by others: one
// moment, and one set of wavelengths.
#pragma once

#include <cstdint>
#include <optional>

#include "render/color/spectra.h"
#include "render/integrator/scene_tables.h"
#include "render/sampling/sampler.h"
#include "render/sensor/shutter.h"
#include "render/transport/vertex/dimensions.h"

namespace tessera::render::TESSERA_ISA {

/// Numbers in [0, 1) that paths have instead of their own.
struct PassShare {
  std::optional<float> time;        // from 0 (the shutter opens) to 1
  std::optional<float> wavelength;  // that sample_wavelengths() takes
  // Samples of all pixels have times as paths from lights have them, for they are joined to such paths.
  bool times_of_lights = false;
};

/// Returns what the paths of a pass share. Where things move, the times of two or more passes are spread over
/// the exposure as a pixel's samples are. Where light has wavelengths, steps of a quarter of the golden ratio
/// (1.618) spread the lanes, which are a quarter apart, evenly between one another, and the first lanes over
/// all wavelengths. `seed` is the sampler's.
inline PassShare share_of_pass(const SceneTables& scene, std::uint64_t seed, std::uint32_t pass) {
  constexpr std::uint32_t kStep = 0x678dde6eu;  // of 2^32
  PassShare share;
  const UInt key = Sampler::pixel_hash(seed, UInt(0u), UInt(0x50617373u));
  if (scene.any_motion) {
    const Sampler passes(scene.sampler.kind, key, reverse_bits(UInt(pass)));
    share.time = time_of_light(scene.sensor, passes.get_2d(dimension::kTime).x).lane(0);
  }
  if (kSpectral) share.wavelength = to_unit_float(hash(key) + UInt(pass * kStep)).lane(0);
  return share;
}

/// The wavelengths of paths: their own, by `numbers`, or those of the pass.
template <class Numbers>
TESSERA_INLINE Wavelengths wavelengths_of(const SceneTables& scene, const Numbers& numbers,
                                          const PassShare& shared) {
  return sample_wavelengths(scene.sensor.response.sensitivity, [&] {
    return shared.wavelength ? Float(*shared.wavelength) : numbers.get_2d(dimension::kTime).y;
  });
}

}  // namespace tessera::render::TESSERA_ISA
