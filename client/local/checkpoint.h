// The folder in which `tessera render` keeps what it has rendered, to go on after a break.
#pragma once

#include <filesystem>

#include "absl/status/status.h"

namespace tessera::client {

/// Makes the folder, or takes one that was made so. InvalidArgument when there is something else: nobody's
/// files are taken for a checkpoint, nor deleted with it.
absl::Status open_checkpoint(const std::filesystem::path& folder);

/// Deletes a folder that open_checkpoint() has made or taken.
absl::Status delete_checkpoint(const std::filesystem::path& folder);

}  // namespace tessera::client
