// pbrt-v4 scene files [Pharr et al. 2023; pbrt.org/fileformat-v4].
#pragma once

#include <filesystem>

#include "absl/status/statusor.h"
#include "import/input/imported_scene.h"

namespace tessera::client::pbrt {

/// Reads a .pbrt or .pbrt.gz file with everything it names. PLY files are read on `threads` threads (0: one a
/// core). InvalidArgument with up to 20 located errors, one a line; what is not supported becomes a warning
/// that says what is done instead.
absl::StatusOr<ImportedScene> import_pbrt(const std::filesystem::path& path, int threads);

}  // namespace tessera::client::pbrt
