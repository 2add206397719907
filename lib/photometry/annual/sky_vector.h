// Luminances of the patches of a sky.
#pragma once

#include <cstddef>
#include <vector>

#include "photometry/annual/sky_patches.h"
#include "photometry/sky/sky.h"

namespace tessera::photometry {

/// Where the sun is in a vector of patches.
enum class SunPlacement {
  kNone,
  kOwnPatch,  // in the patch that it is in
  kNearest4   // in the four patches nearest to it, weighed by their distance, as Radiance's gendaymtx does
};

/// Mean luminances in cd/m^2 of all patches, the ground's (number 0) first. Those of the sky are scaled, such
/// that the patches together give the horizontal illuminance of the sky. The sun's patches have so much more
/// luminance that their solid angles give its illuminance of a surface that faces it.
std::vector<double> sky_vector(const SkyPatches& patches, const Sky& sky, SunPlacement placement);

/// Likewise for the sun alone.
std::vector<double> sun_vector(const SkyPatches& patches, const Sky& sky, SunPlacement placement);

}  // namespace tessera::photometry
