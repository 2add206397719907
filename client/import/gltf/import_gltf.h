// glTF 2.0 files: .gltf and .glb.
#pragma once

#include <filesystem>
#include <string_view>

#include "absl/status/statusor.h"
#include "import/gltf/gltf_options.h"
#include "import/input/imported_scene.h"

namespace tessera::client::gltf {

/// Imports the scene of a glTF file as it is at the time of `options` (docs/gltf.md has what becomes of
/// what). Statuses as of import_scene; places in the file are JSON pointers (RFC 6901). Memory is bounded by
/// a small multiple of the files' sizes, but for what compressed data grow to.
absl::StatusOr<ImportedScene> import_gltf(const std::filesystem::path& path, const GltfOptions& options);

/// The same of a .glb that a converter made of the file `path`, by whose folder and name it goes. Its numbers
/// are not held against what glTF demands of them beyond soundness: normals need not be of length 1.
absl::StatusOr<ImportedScene> import_converted(const std::filesystem::path& path, std::string_view glb,
                                               const GltfOptions& options);

}  // namespace tessera::client::gltf
