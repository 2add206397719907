// From a polynomial in x, y and z to what the kernels read of it.
#pragma once

#include <algorithm>
#include <cmath>

#include "expression/polynomial.h"
#include "render/shape/implicit/implicit_record.h"

namespace tessera::render {

/// Coefficients in the order of ImplicitRecord, and what bounds their sum over its box, which is set.
inline void set_polynomial(const expression::Polynomial& polynomial, ImplicitRecord& record) {
  const int n = record.degree = polynomial.degree;
  double reach[3];
  for (int i = 0; i < 3; ++i) reach[i] = std::max(std::abs(record.low[i]), std::abs(record.high[i]));
  for (int i = n; i >= 0; --i) {
    for (int j = n - i; j >= 0; --j) {
      for (int k = n - i - j; k >= 0; --k) {
        const double c = polynomial.at(i, j, k);
        const double term =
            std::abs(c) * std::pow(reach[0], i) * std::pow(reach[1], j) * std::pow(reach[2], k);
        record.coefficients.push_back(c);
        record.magnitude += term;
        record.slope += term * (i / reach[0] + j / reach[1] + k / reach[2]);
      }
    }
  }
}

}  // namespace tessera::render
