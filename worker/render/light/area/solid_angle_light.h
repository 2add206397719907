// Sampling a flat light by solid angle, besides the solid angle itself.
#pragma once

#include "render/light/light_access.h"
#include "render/sampling/bilinear.h"

namespace tessera::render::TESSERA_ISA {

/// The receiver's cosine with the direction to a corner. Never zero: the normal may be bent, and the light
/// goes on between its corners.
TESSERA_INLINE Float corner_weight(const Receiver& from, Vec3 to_corner, Float inverse_distance) {
  return max(dot(from.normal, to_corner) * inverse_distance, 0.02f);
}

/// Sample `by_area`, where `by_angle` with the density `pdf` instead.
TESSERA_INLINE LightSample with_density(LightSample by_area, Mask by_angle, Float pdf) {
  by_area.pdf = select(by_angle & by_area.valid, pdf, by_area.pdf);
  return by_area;
}

}  // namespace tessera::render::TESSERA_ISA
