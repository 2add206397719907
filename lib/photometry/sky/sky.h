// A sky in absolute units, with its sun and the ground.
#pragma once

#include "photometry/horizon.h"
#include "photometry/sky/sky_pattern.h"
#include "photometry/sky/typical_daylight.h"

namespace tessera::photometry {

struct Sky {
  SkyPattern pattern = {};
  HorizonDirection sun = {};
  double integral = 0;                // horizontal_integral() of the pattern
  double luminance_scale = 0;         // cd/m^2 of a relative luminance of 1
  double sun_normal_illuminance = 0;  // lx, of a surface that faces the sun; the sun is not in luminance()
  double ground_luminance = 0;        // cd/m^2 of all directions below the horizon
};

/// The sky of a pattern that gives the illuminances of `daylight`, over a ground that is lit by both and
/// reflects diffusely: its luminance is reflectance times illuminance over pi.
Sky make_sky(const SkyPattern& pattern, const HorizonDirection& sun, const Daylight& daylight,
             double ground_reflectance);

/// Luminance in cd/m^2 of the sky, or of the ground below the horizon; without the sun.
double luminance(const Sky& sky, const HorizonDirection& w);

/// Illuminance in lx of an unobstructed horizontal surface by the sky alone, by the sun
/// alone, and by both: what daylight factors are fractions of has no sun.
double diffuse_horizontal_illuminance(const Sky& sky);
double sun_horizontal_illuminance(const Sky& sky);
double horizontal_illuminance(const Sky& sky);

}  // namespace tessera::photometry
