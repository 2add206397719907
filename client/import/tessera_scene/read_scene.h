// Scene messages in files.
#pragma once

#include <filesystem>

#include "absl/status/statusor.h"
#include "import/input/imported_scene.h"

namespace tessera::client::tessera_scene {

/// A Scene in protobuf text format. Every BlobRef names a file by `path`, relative to the scene file; digest
/// and size are filled in, and checked where they are given. A mesh may be a .ply file, which is converted,
/// or a mesh blob. InvalidArgument with located errors, one a line.
absl::StatusOr<ImportedScene> read_text_scene(const std::filesystem::path& path);

/// The same of a serialized Scene, whose errors have no lines.
absl::StatusOr<ImportedScene> read_binary_scene(const std::filesystem::path& path);

}  // namespace tessera::client::tessera_scene
