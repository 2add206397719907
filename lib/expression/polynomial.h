// Polynomials of x, y and z, by their coefficients.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "expression/expression.h"

namespace tessera::expression {

inline constexpr int kMaxDegree = 12;

/// Coefficients in the order of index_of(), of all powers up to the degree.
struct Polynomial {
  int degree = 0;
  std::vector<double> coefficients;

  double at(int i, int j, int k) const { return coefficients[index_of(i, j, k)]; }
  /// The place of x^i y^j z^k: lower degrees first, so that a polynomial begins like one of higher degree.
  static std::size_t index_of(int i, int j, int k) {
    const std::size_t d = static_cast<std::size_t>(i + j + k), e = static_cast<std::size_t>(j + k);
    return d * (d + 1) * (d + 2) / 6 + e * (e + 1) / 2 + static_cast<std::size_t>(k);
  }
};

/// The expression multiplied out, or nothing where it is no polynomial of degree 0 to 12. Sums and products
/// are rounded as doubles are: coefficients that are whole numbers below 2^53 are exact. They may be
/// infinite.
std::optional<Polynomial> expand(const Expression& expression);

}  // namespace tessera::expression
