// The end of every import.
#pragma once

#include <string>

#include "import/input/blob_collector.h"
#include "import/input/diagnostics.h"
#include "import/input/imported_scene.h"

namespace tessera::client {

/// The scene by this name, with text that protobuf accepts, its blobs, and the warnings.
ImportedScene finished_scene(v1::Scene scene, std::string name, BlobCollector blobs,
                             const Diagnostics& diagnostics);

}  // namespace tessera::client
