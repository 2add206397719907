// Mitsuba 3 scene files.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "import/input/imported_scene.h"

namespace tessera::client::mitsuba {

/// Imports a Mitsuba 3 scene (.xml) as Mitsuba's RGB modes render it. `defines` override the file's
/// <default>s; `threads` read meshes (0: one a core). Statuses as of import_scene.
absl::StatusOr<ImportedScene> import_mitsuba(const std::filesystem::path& path,
                                             const std::map<std::string, std::string>& defines, int threads);

}  // namespace tessera::client::mitsuba
