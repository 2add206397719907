// Perlin noise and its sums, 16 points at a time [Perlin 1985; Pharr, Jakob & Humphreys, Physically Based
// Rendering, 3rd ed., sec. 10.6]. Points beyond +-2^22 are held there: floats have no fraction left.
#pragma once

#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

/// In about [-1, 1], zero at points with integer coordinates.
Float noise(Vec3 p);

/// Sum of `octaves` noises, each 1.99 times finer and `roughness` times weaker than the one before.
Float fractal_noise(Vec3 p, float roughness, int octaves);

/// The same of absolute values, and the mean of all further octaves.
Float turbulence(Vec3 p, float roughness, int octaves);

}  // namespace tessera::render::TESSERA_ISA
