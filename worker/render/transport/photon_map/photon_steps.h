// The way of a photon in one number: how often it was scattered, and which layers its light may be of.
#pragma once

#include <cstddef>
#include <cstdint>

#include "layers/limits.h"
#include "render/core/wide.h"
#include "wire/limits.h"

namespace tessera::render::TESSERA_ISA {

inline constexpr int kLayerStateBits = 10;
static_assert(layers::kMaxStates <= std::size_t{1} << kLayerStateBits);
static_assert(std::uint64_t{wire::kMaxDepth} + 2 < std::uint64_t{1} << (31 - kLayerStateBits));

/// `state` of the layers' automaton for paths from lights; 0 where there are no layers.
TESSERA_INLINE Int photon_steps(int events, Int state) { return state + (events << kLayerStateBits); }
/// Lanes that were scattered fewer than `events` times, which is not negative.
TESSERA_INLINE Mask has_fewer_events(Int steps, int events) { return steps < (events << kLayerStateBits); }
TESSERA_INLINE Int layer_state_of(Int steps) { return steps & Int((1 << kLayerStateBits) - 1); }

}  // namespace tessera::render::TESSERA_ISA
