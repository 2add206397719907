// Which light to sample.
#pragma once

#include "render/light/light.h"

namespace tessera::render::TESSERA_ISA {

/// A light a lane.
struct LightPick {
  Int light;
  Float pmf;    // probability of this light, given the receiver
  Float u;      // rest of the number that picked it, uniform in [0, 1) again
  Mask picked;  // there is one: no light can reach the others
};

/// Whether lights are to be sampled at all.
TESSERA_INLINE bool samples_lights(const LightTable& table) { return !table.selection.threshold.empty(); }

/// A light for each receiver, by LightTable::tree where there is one, else by LightTable::selection. `u` is
/// uniform in [0, 1). Lights are to be sampled.
LightPick pick_light(const LightTable& table, const Receiver& from, Float u, Mask active);

/// The probability with which pick_light() gives `light`; zero where it never does.
Float pick_pmf(const LightTable& table, Int light, const Receiver& from, Mask active);

}  // namespace tessera::render::TESSERA_ISA
