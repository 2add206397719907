// One moment for all paths of a pass: what lights have lit is looked for where it was then.
#pragma once

#include <cstdint>
#include <optional>

#include "render/integrator/scene_tables.h"
#include "render/sampling/sampler.h"
#include "render/transport/vertex/dimensions.h"

namespace tessera::render::TESSERA_ISA {

/// The time of a pass's paths within the exposure, in [0, 1), where things move. Two or more passes are
/// spread over it as a pixel's samples are. `seed` is the sampler's.
inline std::optional<float> time_of_pass(const SceneTables& scene, std::uint64_t seed, std::uint32_t pass) {
  if (!scene.any_motion) return std::nullopt;
  const Sampler passes(scene.sampler.kind, Sampler::pixel_hash(seed, UInt(0u), UInt(0x50617373u)),
                       reverse_bits(UInt(pass)));
  return passes.get_2d(dimension::kTime).x.lane(0);
}

}  // namespace tessera::render::TESSERA_ISA
