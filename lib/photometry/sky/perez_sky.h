// The all-weather sky: from what weather files hold to luminances.
#pragma once

#include "photometry/sky/sky_pattern.h"
#include "photometry/sky/typical_daylight.h"

namespace tessera::photometry {

/// W/m^2
struct Irradiances {
  double direct_normal = 0;       // of a surface that faces the sun, by the sun
  double diffuse_horizontal = 0;  // by the sky
};

/// The weather, in the model's terms [Perez1990].
struct PerezWeather {
  double clearness = 1;   // epsilon: from 1, overcast, to some 12, clear
  double brightness = 0;  // Delta: sky light over extraterrestrial light, times the air mass
};

/// `sun_zenith` in radians, below a right angle; `outside`: extraterrestrial irradiance of a surface that
/// faces the sun, W/m^2. A sky without diffuse light has the clearness of the clearest class.
PerezWeather perez_weather(const Irradiances& measured, double sun_zenith, double outside);

/// Pattern of the sky [Perez1993], with the coefficients of that paper and its erratum. Where the paper's fit
/// is left, bounds hold: those of Radiance's gendaylit (a brightness of 0.01 to 0.6, of 0.2 at least in
/// classes of clearness from 1.065 to 2.8), and no gradation that grows beyond all bounds at the horizon.
SkyPattern perez_pattern(const PerezWeather& weather, double sun_zenith);

/// Illuminances by the luminous efficacies of sun and sky [Perez1990, table 4], brightness within the same
/// bounds.
Daylight perez_daylight(const Irradiances& measured, const PerezWeather& weather, double sun_zenith,
                        double dew_point_celsius);

}  // namespace tessera::photometry
