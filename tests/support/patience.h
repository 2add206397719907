// How long a test waits.
#pragma once

#include <chrono>

namespace tessera::support {

/// Longest time that anything in a test may take; reached only when it hangs, however busy the machine is.
inline constexpr std::chrono::minutes kPatience{5};

}  // namespace tessera::support
