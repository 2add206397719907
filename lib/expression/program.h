// A function of x, y and z as a straight line of instructions over registers: what compile() makes, and what
// the kernels run (worker/render/shape/implicit/run_program.h).
#pragma once

#include <cstdint>
#include <vector>

namespace tessera::expression {

/// All are defined for all real numbers, so that a surface has no holes for want of a value: the square root
/// of a negative number is 0, as is its power; log(x) below 1e-300 is log(1e-300).
enum class Op : std::uint8_t {
  kX,
  kY,
  kZ,
  kConstant,
  kAdd,
  kSubtract,
  kMultiply,
  kDivide,
  kNegate,
  kPower,  // a power with a whole exponent
  kPow,    // a power with any exponent; of negative numbers: 0
  kSqrt,
  kSin,
  kCos,
  kExp,
  kLog,
  kAbs,
  kMin,
  kMax,
  kNoise,  // Perlin's, of three numbers [Perlin2002]
};

struct Instruction {
  Op op = Op::kConstant;
  std::uint8_t target = 0;
  std::uint8_t from[3] = {};
  std::int32_t power = 0;  // kPower
  double value = 0;        // kConstant
};

/// Registers 0, 1 and 2 hold x, y and z at the beginning; the last instruction's target is the value.
struct Program {
  std::vector<Instruction> instructions;
  int registers = 3;
};

inline constexpr int kMaxRegisters = 64;

}  // namespace tessera::expression
