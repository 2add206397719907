// XML -> Document: includes, parameters, search folders, aliases and references.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "import/input/diagnostics.h"
#include "import/mitsuba/document/values.h"

namespace tessera::client::mitsuba {

/// Reads a scene with all that it includes. Errors go to `diagnostics`, several of them where possible; with
/// errors the document is as complete as it could be made. `defines` take the place of <default>s; one that
/// no file asks for is a warning.
Document read_document(const std::filesystem::path& path, const std::map<std::string, std::string>& defines,
                       Diagnostics& diagnostics);

}  // namespace tessera::client::mitsuba
