// Functions f(x, y, z) of implicit surfaces, as text. docs/scenes.md explains them.
//
//   equation   = sum [ "=" sum ]              f = g stands for f - g
//   sum        = product { ( "+" | "-" ) product }
//   product    = factor { ( "*" | "/" ) factor }
//   factor     = ( "+" | "-" ) factor | atom [ "^" factor ]
//   atom       = number | "x" | "y" | "z" | "pi" | "(" sum ")" | name "(" sum { "," sum } ")"
//   name       = sqrt | sin | cos | exp | log | abs (of one) | min | max (of two or more) | pow (of two)
//              | noise (of three)
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "expression/program.h"

namespace tessera::expression {

/// An operation; operands stand before it. Equal operations are one node.
struct Node {
  Op op = Op::kConstant;
  std::int32_t from[3] = {-1, -1, -1};
  std::int32_t power = 0;  // kPower
  double value = 0;        // kConstant

  bool operator==(const Node&) const = default;
};

/// The last operation to be done is `root`; others may be of no use to it.
struct Expression {
  std::vector<Node> nodes;
  std::int32_t root = 0;
};

/// Most characters, operations, parentheses and signs within one another; largest whole exponent.
inline constexpr std::size_t kMaxCharacters = 32768;
inline constexpr std::size_t kMaxOperations = 2048;
inline constexpr int kMaxNesting = 64;
inline constexpr int kMaxExponent = 64;

/// InvalidArgument, "column 3: ...", for what is no such function, or is larger than these. Parts without x,
/// y or z are computed here.
absl::StatusOr<Expression> parse(std::string_view text);

/// InvalidArgument where it needs more registers at once than there are.
absl::StatusOr<Program> compile(const Expression& expression);

}  // namespace tessera::expression
