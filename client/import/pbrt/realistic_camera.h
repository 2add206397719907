// pbrt's camera "realistic": a lens in a file of its own.
#pragma once

#include "import/pbrt/camera_film.h"
#include "import/pbrt/context.h"

namespace tessera::client::pbrt {

/// Film irradiance as in pbrt-v4: darker the smaller the aperture. Errors of the lens name its file and line.
void write_realistic_camera(Context& context, Directive& camera, Directive& film);

}  // namespace tessera::client::pbrt
