// The Mitsuba sensor, with its film and sampler -> Camera, Film and settings.
#pragma once

#include "import/mitsuba/matter/media.h"

namespace tessera::client::mitsuba {

void write_sensor(Context& context, MediumTable& media, Object& sensor);

}  // namespace tessera::client::mitsuba
