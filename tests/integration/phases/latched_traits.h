// An algorithm that renders what `path` renders, and waits where a test says so: what a test orders by it
// does not depend on how fast a machine is.
#pragma once

namespace tessera::integration {

inline constexpr const char* kLatched = "latched";

/// Environment variable of a worker: "NUMBER:FILE". Units of `latched` behind the first NUMBER that the
/// process has begun wait until the file is there.
inline constexpr const char* kLatchVariable = "TESSERA_TEST_LATCH";

}  // namespace tessera::integration
