// How large combinations of solids (Csg in shape.proto) may be.
#pragma once

namespace tessera::wire {

inline constexpr int kMostCsgDepth = 1000;    // groups within one another
inline constexpr int kMostCsgSolids = 65536;  // solids of one combination

}  // namespace tessera::wire
