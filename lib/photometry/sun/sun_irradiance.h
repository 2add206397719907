// The sun outside the atmosphere, and how much of that is in its way.
#pragma once

namespace tessera::photometry {

/// At a distance of 1 au: W/m^2, the value that [Perez1990] is fitted with, and lx [Darula2002].
inline constexpr double kSolarConstant = 1367;
inline constexpr double kLuminousSolarConstant = 133'800;

/// Irradiance in W/m^2 of a surface that faces the sun, outside the atmosphere.
inline double extraterrestrial_irradiance(double distance_au) {
  return kSolarConstant / (distance_au * distance_au);
}

/// Air in the way of light from an altitude in degrees, over that in the zenith, at sea level [Kasten1989].
/// Below the horizon it is what it is there, some 38.
double relative_air_mass(double altitude_degrees);

}  // namespace tessera::photometry
