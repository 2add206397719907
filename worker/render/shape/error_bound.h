// How far off a point of a surface may be for rounding.
#pragma once

#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

/// 2^-21: eight roundings of a float. Interpolating a point takes about five; the rest covers the
/// intersector's own.
inline constexpr float kPositionError = 4.76837158e-7f;

TESSERA_INLINE Float largest_coordinate(Vec3 v) { return max(max(abs(v.x), abs(v.y)), abs(v.z)); }
/// Error along the normal of a point whose coordinates are each off by at most `e`.
TESSERA_INLINE Float along_normal(Vec3 n, Float e) { return e * (abs(n.x) + abs(n.y) + abs(n.z)); }

}  // namespace tessera::render::TESSERA_ISA
