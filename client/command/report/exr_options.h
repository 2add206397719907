// Options that say how an EXR is written, the same for all commands that write one.
#pragma once

#include "image/exr.h"
#include "options/program.h"

namespace tessera::client {

void define_exr_options(options::Command& command, ExrFormat& exr);
/// An option for commands that write the pictures of a job, which may have several views.
options::Option define_multiview(options::Command& command, ExrFormat& exr);

}  // namespace tessera::client
