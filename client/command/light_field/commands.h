// The commands within `tessera lightfield` that have files of their own.
#pragma once

#include "command/command_line.h"

namespace tessera::client {

void add_light_field_capture(CommandLine& line);
void add_light_field_view(CommandLine& line);
void add_light_field_refocus(CommandLine& line);

}  // namespace tessera::client
