// Integer hashing, wide.
#pragma once

#include "render/core/wide.h"

namespace tessera::render::TESSERA_ISA {

/// [Wellons 2018] "lowbias32": a bijection of 32 bits whose output bits all depend on all input bits.
TESSERA_INLINE UInt hash(UInt x) {
  x = (x ^ shift_right<16>(x)) * 0x7feb352du;
  x = (x ^ shift_right<15>(x)) * 0x846ca68bu;
  return x ^ shift_right<16>(x);
}
TESSERA_INLINE UInt hash(UInt a, UInt b) { return hash(a ^ (hash(b) + 0x9e3779b9u)); }

}  // namespace tessera::render::TESSERA_ISA
