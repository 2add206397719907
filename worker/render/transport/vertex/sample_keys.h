// Random numbers of a batch of samples: one entry a slot.
#pragma once

#include "render/sampling/sampler.h"
#include "render/transport/vertex/lanes.h"

namespace tessera::render::TESSERA_ISA {

struct SampleKeys {
  // Arguments of Sampler
  alignas(64) Lanes<std::uint32_t> pixel_hash, reversed_sample;

  Sampler sampler(SamplerKind kind, Int slot, Mask active) const {
    return {kind, gather(pixel_hash, slot, active), gather(reversed_sample, slot, active)};
  }
  /// A key that all samples have for themselves.
  UInt key(Int slot, Mask active) const {
    return hash(gather(pixel_hash, slot, active), gather(reversed_sample, slot, active));
  }
};

}  // namespace tessera::render::TESSERA_ISA
