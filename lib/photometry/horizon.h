// Directions as seen from a place on the ground.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tessera::photometry {

inline constexpr double kRadiansPerDegree = std::numbers::pi / 180;

/// A unit vector; the horizon is at up = 0.
struct HorizonDirection {
  double east = 0, north = 0, up = 1;
};

/// Cosine of the angle between two directions, within -1 and 1.
inline double cosine_between(const HorizonDirection& a, const HorizonDirection& b) {
  return std::clamp(a.east * b.east + a.north * b.north + a.up * b.up, -1.0, 1.0);
}

/// Angle between two directions in radians; precise for small angles, too.
inline double angle_between(const HorizonDirection& a, const HorizonDirection& b) {
  const double x = a.east - b.east, y = a.north - b.north, z = a.up - b.up;
  return 2 * std::asin(std::min(std::sqrt(x * x + y * y + z * z) / 2, 1.0));
}

/// `azimuth_degrees` from north through east.
inline HorizonDirection toward(double altitude_degrees, double azimuth_degrees) {
  const double altitude = altitude_degrees * kRadiansPerDegree, azimuth = azimuth_degrees * kRadiansPerDegree;
  return {std::cos(altitude) * std::sin(azimuth), std::cos(altitude) * std::cos(azimuth), std::sin(altitude)};
}

/// Altitude above the horizon in degrees, negative below it.
inline double altitude_degrees(const HorizonDirection& w) {
  return std::atan2(w.up, std::hypot(w.east, w.north)) / kRadiansPerDegree;
}

/// From north through east, 0 to 360.
inline double azimuth_degrees(const HorizonDirection& w) {
  const double turn = std::atan2(w.east, w.north) / kRadiansPerDegree;
  return turn < 0 ? turn + 360 : turn;
}

}  // namespace tessera::photometry
