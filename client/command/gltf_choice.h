// Options that choose from a glTF file, as a group of --help.
#pragma once

#include "import/gltf/gltf_options.h"
#include "options/program.h"

namespace tessera::client {

void define_gltf_options(options::Command& command, GltfOptions& gltf);

}  // namespace tessera::client
