// A camera with a hole instead of a lens, as kernels read it. The hole's middle is the origin of sensor
// space, and a place of the raster, which lies on the plane z = 1, is seen along the ray through that middle.
#pragma once

#include <cstdint>
#include <vector>

namespace tessera::render {

/// Light of a point of the scene is spread over the film around the middle of the shadow that it throws of
/// the hole. Parts of the light within radii, in units of the shadow's, are told for this many radii: from 0
/// to HoleTable::reach in even steps, and from there in even steps of 1 / radius to infinity.
inline constexpr std::int32_t kHoleNearSteps = 960, kHoleFarSteps = 64;
inline constexpr std::int32_t kHoleNodes = kHoleNearSteps + kHoleFarSteps + 1;

struct HoleTable {
  float radius = 0;  // of the hole, units of sensor space
  // A radius of 1 on the film is this far on the plane of places, and a ray from the edge of the hole turns
  // by `inward` towards the axis to meet, at the distance that is sharp to the table, one from its middle.
  float spread = 0, inward = 0;
  float weight = 1;  // of rays, times cos^4
  // For wavelengths that are evenly spaced: kHoleNodes parts of the light, and the reach of their radii.
  // Empty: light goes straight, and is spread evenly over the shadow.
  std::vector<float> light, reach;
  std::int32_t wavelengths = 1;
  float first_nm = 0, wavelengths_per_nm = 0;
};

}  // namespace tessera::render
