// Small files that are replaced as a whole: keys, certificates, tokens.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string_view>

#include "absl/status/status.h"

namespace tessera::base {

/// Makes `path` hold `bytes`, durably, through a file beside it: whoever reads sees the old or the new
/// contents, and nobody but those whom `mode` allows sees the new ones at any moment. Unavailable, with the
/// path, when that does not work.
absl::Status replace_file(const std::filesystem::path& path, mode_t mode, std::string_view bytes);

/// Makes the folder and those above it. Unavailable, with the path, when that does not work.
absl::Status make_folder(const std::filesystem::path& folder);

}  // namespace tessera::base
