// The raster of panoramas: a place is the longitude, to the right from the sensor's z axis, and the latitude,
// upwards, in radians. Rays of one latitude are the same in the frames of their longitudes, whose x is to the
// right and whose z is ahead.
#pragma once

#include "render/core/constants.h"
#include "render/sensor/sensor.h"

namespace tessera::render::TESSERA_ISA {

inline constexpr float kQuarterTurn = kPi / 2;

struct PanoramaPlace {
  Float longitude, latitude;
  Mask valid;
};

/// Beyond a pole, the meridian is the opposite one.
inline PanoramaPlace panorama_place(Vec2 place) {
  const Mask over = abs(place.y) > kQuarterTurn;
  const Float latitude = select(over, copysign(Float(kPi), place.y) - place.y, place.y);
  return {place.x + select_or_zero(over, Float(kPi)), latitude, abs(latitude) <= kQuarterTurn};
}

/// The longitude `turn`, which may be off by whole turns, within half a turn of the middle of the picture.
inline Float longitude_in_picture(const SensorRecord& sensor, Float turn) {
  const float middle = sensor.offset_x + 0.5f * sensor.scale_x * static_cast<float>(sensor.width);
  return turn - 2 * kPi * floor((turn - middle) * kInv2Pi + 0.5f);
}

/// A vector of a longitude's frame in sensor space.
inline Vec3 from_longitude(Float longitude, Vec3 v) {
  const Float s = sin(longitude), c = cos(longitude);
  return {fma(v.x, c, v.z * s), v.y, fma(v.z, c, v.x * s * -1.0f)};
}

/// Density of samples of a pixel at a point, by area across the ray to it: `by_longitude` and `by_latitude`
/// are what the point moves by as they grow, and `along` is the ray's direction, of any length.
inline Float panorama_density(const SensorRecord& sensor, Vec3 by_longitude, Vec3 by_latitude, Vec3 along) {
  const Float area = abs(dot(cross(by_longitude, by_latitude), normalize(along)));
  return 1.0f / (max(area, 1e-30f) * pixel_area(sensor));
}

}  // namespace tessera::render::TESSERA_ISA
