#include "render/shape/implicit/bernstein.h"

#include <algorithm>
#include <cmath>

#include "render/core/wide.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// s^m = (u - (1 - u))^m with u = (1 + s) / 2, times (u + (1 - u))^(n - m): products of sums of monomials of
/// the same degree, whose coefficients are those of the basis times binomials.
BernsteinTable make_table() {
  BernsteinTable table{};
  double binomial[kMaxRayDegree + 1][kMaxRayDegree + 1] = {};
  for (int n = 0; n <= kMaxRayDegree; ++n) {
    for (int k = 0; k <= n; ++k)
      binomial[n][k] = k == 0 || k == n ? 1 : binomial[n - 1][k - 1] + binomial[n - 1][k];
  }
  for (int n = 0; n <= kMaxRayDegree; ++n) {
    for (int m = 0; m <= n; ++m) {
      for (int k = 0; k <= n; ++k) {
        double sum = 0;
        for (int i = std::max(0, k - (n - m)); i <= std::min(k, m); ++i)
          sum += ((m - i) % 2 ? -1 : 1) * binomial[m][i] * binomial[n - m][k - i];
        table.of[n][m][k] = sum / binomial[n][k];
      }
    }
  }
  return table;
}

/// Values over an interval lie between the least and the largest coefficient.
struct Piece {
  double b[kMaxRayDegree + 1];
  double low, high;
};

enum class Roots { kNone, kOne, kUnknown, kAllZero };

/// How many roots the signs of the coefficients allow [Descartes' rule]; those within `error` of zero may
/// have any sign.
Roots count_roots(const Piece& piece, int degree, double error) {
  int positive = 0, negative = 0, changes = 0, last = 0;
  bool zero_between = false, zeros = false;
  for (int k = 0; k <= degree; ++k) {
    const int sign = piece.b[k] > error ? 1 : piece.b[k] < -error ? -1 : 0;
    if (sign == 0) {
      zeros = zero_between = true;
      continue;
    }
    (sign > 0 ? positive : negative)++;
    if (last != 0 && sign != last) ++changes;
    if (last == sign && zero_between) changes += 2;  // the one between may be of the other sign
    last = sign, zero_between = false;
  }
  if (positive + negative == 0) return Roots::kAllZero;
  if (!zeros && changes == 0) return Roots::kNone;
  const bool sure_ends = std::abs(piece.b[0]) > error && std::abs(piece.b[degree]) > error;
  return changes == 1 && sure_ends ? Roots::kOne : Roots::kUnknown;
}

/// Halves by de Casteljau's rule: means alone, which add no error to speak of.
void halve(const Piece& whole, int degree, Piece& first, Piece& second) {
  const double middle = 0.5 * (whole.low + whole.high);
  second = whole;
  for (int k = 0; k <= degree; ++k) {
    first.b[k] = second.b[0];
    for (int i = 0; i + k < degree; ++i) second.b[i] = 0.5 * (second.b[i] + second.b[i + 1]);
  }
  first.low = whole.low, first.high = middle;
  second.low = middle, second.high = whole.high;
}

constexpr int kDeepest = 42;

}  // namespace

const BernsteinTable& bernstein_table() {
  static const BernsteinTable table = make_table();
  return table;
}

double first_root_by_intervals(const RayPolynomial& p, bool any) {
  const auto& basis = bernstein_table().of[p.degree];
  Piece stack[kDeepest + 2];
  Piece& whole = stack[0];
  whole = {{}, -1, 1};
  for (int m = 0; m <= p.degree; ++m) {
    for (int k = 0; k <= p.degree; ++k) whole.b[k] += p.c[m] * basis[m][k];
  }
  for (int top = 0; top >= 0;) {
    const Piece piece = stack[top];
    const Roots roots = count_roots(piece, p.degree, p.error);
    if (roots == Roots::kNone) {
      --top;
      continue;
    }
    if (roots == Roots::kOne) return any ? piece.high : refine_root(p, piece.low, piece.high);
    // Zero to rounding, or too narrow to be cut: the surface is touched here.
    if (roots == Roots::kAllZero || piece.high - piece.low < 0x1p-40) return 0.5 * (piece.low + piece.high);
    halve(piece, p.degree, stack[top + 1], stack[top]);
    ++top;
  }
  return kNoRoot;
}

}  // namespace tessera::render::TESSERA_ISA
