// The sensor of pbrt's films, which sees the light, and the bands of its film "spectral".
#pragma once

#include "import/pbrt/camera_film.h"

namespace tessera::client::pbrt {

/// Writes settings for the sensor, white balance, bands and output colour space of a film, and its exposure:
/// pbrt's imaging ratio, `shutter_seconds` x iso / 100. What no picture of red, green and blue has makes the
/// scene ask for light of wavelengths. Errors name a sensor that pbrt-v4 does not know, a temperature, bands
/// and factors that are out of range.
void write_film_sensor(Context& context, Directive& film, double shutter_seconds);

}  // namespace tessera::client::pbrt
