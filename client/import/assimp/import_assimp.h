// OBJ with MTL, STL, FBX and COLLADA, by Assimp.
#pragma once

#include <filesystem>

#include "absl/status/statusor.h"
#include "import/gltf/gltf_options.h"
#include "import/input/imported_scene.h"

namespace tessera::client::assimp {

/// Imports a file that Assimp reads, by way of glTF. InvalidArgument says what Assimp says; Unimplemented
/// where the module with Assimp is not installed.
absl::StatusOr<ImportedScene> import_assimp(const std::filesystem::path& path, const GltfOptions& options);

}  // namespace tessera::client::assimp
