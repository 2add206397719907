// Options that only some integrators have, a group of --help each.
#pragma once

#include "command/jobs/own_wishes.h"
#include "options/program.h"

namespace tessera::client {

void define_own_options(options::Command& command, OwnWishes& own);
/// Those of integrator "radiosity" alone.
void define_radiosity_options(options::Command& command, RadiosityWishes& radiosity);

}  // namespace tessera::client
