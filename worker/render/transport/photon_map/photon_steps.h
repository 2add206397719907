// The way of a photon in one number: how often it was scattered, which layers its light may be of, and
// whether it has light of its first wavelength alone.
#pragma once

#include <cstddef>
#include <cstdint>

#include "layers/limits.h"
#include "render/core/wide.h"
#include "wire/limits.h"

namespace tessera::render::TESSERA_ISA {

inline constexpr int kLayerStateBits = 10;
static_assert(layers::kMaxStates <= std::size_t{1} << kLayerStateBits);
inline constexpr int kStateBits = kLayerStateBits + 1;  // and the one of PathFields::dispersed
static_assert(std::uint64_t{wire::kMaxDepth} + 2 < std::uint64_t{1} << (31 - kStateBits));

/// `state` of the layers' automaton for paths from lights; 0 where there are no layers.
TESSERA_INLINE Int photon_steps(int events, Int state) { return state + (events << kStateBits); }
/// The same, with PathFields::dispersed.
TESSERA_INLINE Int photon_steps(int events, Int state, Int dispersed) {
  return photon_steps(events, state) + dispersed * (1 << kLayerStateBits);
}
/// Lanes that were scattered fewer than `events` times, which is not negative.
TESSERA_INLINE Mask has_fewer_events(Int steps, int events) { return steps < (events << kStateBits); }
TESSERA_INLINE Int layer_state_of(Int steps) { return steps & Int((1 << kLayerStateBits) - 1); }
TESSERA_INLINE Int dispersed_of(Int steps) { return shift_right<kLayerStateBits>(steps) & Int(1); }

}  // namespace tessera::render::TESSERA_ISA
