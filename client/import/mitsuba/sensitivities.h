// Spectral response functions of Mitsuba's films and sensors.
#pragma once

#include "import/mitsuba/document/property_reader.h"

namespace tessera::client::mitsuba {

/// Makes the response functions of a film "specfilm" the sensitivities of the film's own sensor
/// (RenderSettings.sensor "film"): one is all three channels, and of three, red sees the longest waves and
/// blue the shortest. The film's exposure makes a channel what Mitsuba has: the integral of radiance times
/// the function. Warns of any other number of them, and renders what the CIE 1931 observer sees. The scene
/// asks for light of wavelengths.
void write_film_sensitivities(PropertyReader& film);

/// The same of parameter "srf" of a sensor, which is an error beside a "specfilm".
void write_sensor_response(PropertyReader& sensor, bool film_has_own);

}  // namespace tessera::client::mitsuba
