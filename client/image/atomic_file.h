// Files that are either whole or not there.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace tessera::client {

/// The file that symbolic links lead to from `path`; `path` where it is no link, or they lead nowhere.
std::string link_target(const std::string& path);

/// Calls `write` with the name of a temporary file beside `path`, flushes that file to disk and renames it to
/// `path`. Links are followed: what they lead to is replaced, and they stay. When anything fails, `path` is
/// as it was before, the temporary file is gone, and the error names `path`. Devices and pipes
/// (/dev/null) are written in place.
absl::Status replace_file(const std::string& path,
                          const std::function<absl::Status(const std::string&)>& write);

/// `replace_file` with these bytes.
absl::Status replace_file_with(const std::string& path, std::string_view bytes);

}  // namespace tessera::client
