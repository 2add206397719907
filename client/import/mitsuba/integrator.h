// Mitsuba integrators -> render settings.
#pragma once

#include "import/mitsuba/context.h"

namespace tessera::client::mitsuba {

/// `integrator` may be null: Mitsuba's default, path.
void write_integrator(Context& context, Object* integrator);

}  // namespace tessera::client::mitsuba
