// A compiled expression on sixteen points, or on sixteen boxes: Number is Double, Interval or a Dual of them.
#pragma once

#include "render/shape/implicit/dual.h"

namespace tessera::render::TESSERA_ISA {

template <class Number>
__attribute__((noinline)) Number run_program(const expression::Program& program, const Number& x,
                                             const Number& y, const Number& z) {
  using expression::Op;
  alignas(64) Number registers[expression::kMaxRegisters];
  registers[0] = x, registers[1] = y, registers[2] = z;
  Number* last = registers;
  for (const expression::Instruction& i : program.instructions) {
    const Number &a = registers[i.from[0]], &b = registers[i.from[1]], &c = registers[i.from[2]];
    Number& r = *(last = registers + i.target);
    switch (i.op) {
      case Op::kX:
      case Op::kY:
      case Op::kZ:
        r = a;
        break;
      case Op::kConstant:
        r = constant_like(x, i.value);
        break;
      case Op::kAdd:
        r = a + b;
        break;
      case Op::kSubtract:
        r = a - b;
        break;
      case Op::kMultiply:
        r = a * b;
        break;
      case Op::kDivide:
        r = a / b;
        break;
      case Op::kNegate:
        r = -a;
        break;
      case Op::kPower:
        r = whole_power(a, i.power);
        break;
      case Op::kPow:
        r = any_power(a, b);
        break;
      case Op::kSqrt:
        r = square_root(a);
        break;
      case Op::kSin:
        r = sine(a);
        break;
      case Op::kCos:
        r = cosine(a);
        break;
      case Op::kExp:
        r = exponential(a);
        break;
      case Op::kLog:
        r = logarithm(a);
        break;
      case Op::kAbs:
        r = magnitude(a);
        break;
      case Op::kMin:
        r = lesser(a, b);
        break;
      case Op::kMax:
        r = greater(a, b);
        break;
      case Op::kNoise:
        r = noise_of(a, b, c);
        break;
    }
  }
  return *last;
}

}  // namespace tessera::render::TESSERA_ISA
