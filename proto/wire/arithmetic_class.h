// How a machine rounds: its kernels' ISA, and what beyond IEEE 754 decides the bits that they give.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace tessera::wire {

/// "avx512/embree-3.13.5/1f3a9c0e": kernel ISA, Embree's version, and a checksum of how approximating
/// instructions, the C library and the compiler round (worker/render/accel/arithmetic.h). Machines of equal
/// classes give equal bits.
std::string arithmetic_class(std::string_view isa, std::string_view embree_version, std::uint32_t checksum);

/// The kernel ISA of a class: all before the first slash.
inline std::string_view isa_of(std::string_view arithmetic_class) {
  return arithmetic_class.substr(0, arithmetic_class.find('/'));
}

/// False for an ISA alone, which is all that journals before protocol 2 say: of the rounding nothing more is
/// known.
inline bool is_whole_class(std::string_view arithmetic_class) {
  return arithmetic_class.find('/') != std::string_view::npos;
}

}  // namespace tessera::wire
