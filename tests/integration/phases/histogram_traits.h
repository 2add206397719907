// Traits of an algorithm that is not Tessera's own (histogram.cpp); a program that this is linked into
// knows it.
#pragma once

#include "wire/algorithm.h"

namespace tessera::integration {

inline constexpr const char* kHistogram = "histogram";

}  // namespace tessera::integration
