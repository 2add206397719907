// Common parts of the importers of scene files.
#pragma once

#include <string>
#include <string_view>

namespace tessera::fuzz {

/// Imports a file with these bytes; `ending` tells its format. True when it was accepted, and what came out
/// is sound; an error must have a message.
bool accepts_file(std::string_view bytes, const std::string& ending);

}  // namespace tessera::fuzz
