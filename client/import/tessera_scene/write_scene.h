// An imported scene as files.
#pragma once

#include <filesystem>

#include "absl/status/status.h"
#include "import/input/imported_scene.h"

namespace tessera::client::tessera_scene {

/// Writes the Scene to `path`, as text or serialized, and its blobs to "STEM-blobs/" beside it. Fails with
/// the name of the file that cannot be written, or of a blob that is missing.
absl::Status write_scene(const ImportedScene& scene, const std::filesystem::path& path, bool as_text);

}  // namespace tessera::client::tessera_scene
