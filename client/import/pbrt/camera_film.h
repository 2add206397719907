// Camera, Film and PixelFilter -> the scene's camera and film.
#pragma once

#include "import/pbrt/context.h"
#include "import/pbrt/file/parameters.h"

namespace tessera::client::pbrt {

/// A directive that names a type and takes parameters; `type` is pbrt's default until the directive occurs.
struct Directive {
  std::string type;
  ParameterList parameters;
};

/// The filter; its radii default to those of pbrt-v4.
void write_filter(Context& context, Directive& filter);

/// Size, sensor (film_sensor.h) and exposure. `shutter_seconds` is the camera's exposure time. The film comes
/// before the camera.
void write_film(Context& context, Directive& film, double shutter_seconds);

/// All of the camera but where it stands. Lens systems look at the size of the film.
void write_camera(Context& context, Directive& camera, Directive& film);

/// Seconds.
struct ShutterTimes {
  double open = 0, close = 1;
};

ShutterTimes read_shutter(Context& context, Directive& camera);

}  // namespace tessera::client::pbrt
