// Versions that the three programs must agree on before they talk.
#pragma once

#include <cstdint>

namespace tessera::wire {

/// Raised whenever a message or blob layout changes its meaning.
inline constexpr std::uint32_t kProtocolVersion = 5;

/// "0.1.0"; set by the build.
const char* build_version();

}  // namespace tessera::wire
