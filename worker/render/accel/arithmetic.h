// How this machine rounds where IEEE 754 leaves it open.
#pragma once

#include <cstdint>

#include "render/core/wide.h"

namespace tessera::render::TESSERA_ISA {

/// A checksum of all that gives other bits on another machine though kernels and Embree are the same: the
/// instructions that approximate 1/x and 1/sqrt(x), with which Embree divides and whose results each maker of
/// processors chooses; the C library's functions, by which tables are built; and the compiler, which decides
/// where a product and a sum are fused. Takes less than a millisecond.
std::uint32_t arithmetic_checksum();

}  // namespace tessera::render::TESSERA_ISA
