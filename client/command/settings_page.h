// The settings as a document.
#pragma once

#include <string>

namespace tessera::client {

/// docs/settings.md, which comes from settings.proto and from the table of algorithms.
std::string settings_document();

}  // namespace tessera::client
