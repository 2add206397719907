// Places of a panorama: the longitude from the sensor's axis, to the right, and the latitude, upwards, in
// radians.
#pragma once

#include "render/core/constants.h"
#include "render/sensor/sensor.h"

namespace tessera::render::TESSERA_ISA {

struct Bearing {
  Float longitude, latitude;
  Mask valid;  // else the place is beyond all directions
};

inline Bearing bearing_of(Vec2 place) {
  // Beyond a pole, the meridian is the opposite one.
  const Mask over = abs(place.y) > kPi / 2;
  const Float latitude = select(over, copysign(Float(kPi), place.y) - place.y, place.y);
  return {place.x + select_or_zero(over, Float(kPi)), latitude, abs(latitude) <= kPi / 2};
}

/// A longitude within half a turn of the middle of the picture.
inline Float longitude_in_picture(const SensorRecord& sensor, Float longitude) {
  const float middle = sensor.offset_x + 0.5f * sensor.scale_x * static_cast<float>(sensor.width);
  return longitude - 2 * kPi * floor((longitude - middle) * kInv2Pi + 0.5f);
}

}  // namespace tessera::render::TESSERA_ISA
