#include "photometry/sky/sky.h"

namespace tessera::photometry {

Sky make_sky(const SkyPattern& pattern, const HorizonDirection& sun, const Daylight& daylight,
             double ground_reflectance) {
  Sky sky{.pattern = pattern, .sun = sun, .sun_normal_illuminance = daylight.sun_normal};
  sky.integral = horizontal_integral(pattern, sun);
  if (sky.integral > 0) sky.luminance_scale = daylight.diffuse_horizontal / sky.integral;
  const double lit = daylight.diffuse_horizontal + sun_horizontal_illuminance(sky);
  sky.ground_luminance = ground_reflectance * lit / std::numbers::pi;
  return sky;
}

double luminance(const Sky& sky, const HorizonDirection& w) {
  if (!(w.up > 0)) return sky.ground_luminance;
  return sky.luminance_scale * relative_luminance(sky.pattern, w, sky.sun);
}

double diffuse_horizontal_illuminance(const Sky& sky) { return sky.luminance_scale * sky.integral; }

double sun_horizontal_illuminance(const Sky& sky) {
  return sky.sun_normal_illuminance * std::max(sky.sun.up, 0.0);
}

double horizontal_illuminance(const Sky& sky) {
  return diffuse_horizontal_illuminance(sky) + sun_horizontal_illuminance(sky);
}

}  // namespace tessera::photometry
