// Names that are never given twice, by any coordinator.
#pragma once

#include <string>

namespace tessera::server {

/// Random hexadecimal digits: a worker or client that talks to the wrong coordinator, or to one that has
/// forgotten, is not taken for another.
std::string random_identifier(int digits);

}  // namespace tessera::server
