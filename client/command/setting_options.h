// The settings of a renderer (wire/settings.h) as options of a command.
#pragma once

#include <functional>
#include <string>

#include "options/program.h"
#include "tessera/v1/settings.pb.h"

namespace tessera::client {

/// Defines `--set NAME=VALUE` for all settings whose names are `wanted`, and options for those that
/// settings.proto makes options as well.
void define_settings(options::Command& command, v1::RenderSettings& settings,
                     const std::function<bool(const std::string& name)>& wanted);

}  // namespace tessera::client
