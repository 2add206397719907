#pragma once

#include "render/accel/brute/brute.h"
#include "render/accel/structure/ray.h"

namespace tessera::render::TESSERA_ISA {

/// Shows every primitive that the ray might meet to `visitor`: `meet` tests one and returns true where the
/// walk may end; `reach` is how far along the ray hits are still wanted; `enter` counts a node. So do the
/// walks of the other structures.
template <class Visitor>
void walk(const Brute& all, const Box&, const Ray&, Visitor& visitor) {
  for (std::uint32_t i = 0; i < all.count; ++i) {
    if (visitor.meet(i)) return;
  }
}

}  // namespace tessera::render::TESSERA_ISA
