// A light for each of 16 receivers, and a point on it.
#pragma once

#include "render/light/light.h"
#include "render/light/selection/pick.h"

namespace tessera::render::TESSERA_ISA {

struct LightChoice {
  LightPick pick;
  LightSample sample;  // sample of the light that was picked
};

/// Whether one pair picks the light and the point on it, which stratifies the points over all lights together
/// (measured: docs/decisions/0010-bench.md): as long as the pick leaves enough of the number's 24 bits.
TESSERA_INLINE bool one_pair_serves(const LightTable& lights) {
  constexpr std::size_t kMostTogether = 256;
  return lights.lights.size() <= kMostTogether;
}

/// `u_pick` picks the light where one pair does not serve.
TESSERA_INLINE LightChoice choose_light(const LightTable& lights, const Receiver& from, Vec2 u_point,
                                        Float u_pick, Mask wanted) {
  const bool together = one_pair_serves(lights);
  LightChoice choice;
  choice.pick = pick_light(lights, from, together ? u_point.x : u_pick, wanted);
  if (together) u_point.x = choice.pick.u;
  choice.sample = sample_light(lights, choice.pick.light, from, u_point, choice.pick.picked);
  return choice;
}

}  // namespace tessera::render::TESSERA_ISA
