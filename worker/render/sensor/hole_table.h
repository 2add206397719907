// What kernels read of a camera with a hole instead of a lens. Its middle is the origin of sensor space, and
// a place of the raster, which lies on the plane z = 1, is seen along the ray through that middle.
#pragma once

#include <cstdint>
#include <vector>

namespace tessera::render {

/// Light of a point of the scene is spread over the film: where it falls, in units of the hole's radius as
/// the point throws its shadow there, and from the middle of that, is a radius of which this many quantiles
/// are kept for each wavelength.
inline constexpr std::int32_t kHoleNodes = 1025;

struct HoleTable {
  float radius = 0;  // of the hole, units of sensor space
  // A radius of 1 on the film is this far on the plane of places, and a ray from the edge of the hole turns
  // by `inward` towards the axis to meet, at the distance that is sharp to the table, one from its middle.
  float spread = 0, inward = 0;
  float weight = 1;  // of rays, times cos^4
  // Quantiles u of the radius, each times (1 - u) / sqrt(u), which is finite; evenly spaced. Empty: light
  // goes straight, and the spread is a disk.
  std::vector<float> quantiles;
  std::int32_t wavelengths = 1;
  float first_nm = 0, wavelengths_per_nm = 0;
};

}  // namespace tessera::render
