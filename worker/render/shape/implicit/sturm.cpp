#include <algorithm>
#include <cmath>

#include "render/core/wide.h"
#include "render/shape/implicit/ray_polynomial.h"

namespace tessera::render::TESSERA_ISA {

namespace {

constexpr double kUnit = 0x1p-53;

/// A polynomial of the chain, scaled so that its largest coefficient is 1; each is off by `error` at most.
struct Link {
  int degree = 0;
  double c[kMaxRayDegree + 1] = {};
  double error = 0;

  /// 1 or -1; 0 where the errors leave it open.
  int sign_at(double s) const {
    double value = c[degree], sum = std::abs(c[degree]);
    for (int i = degree; i-- > 0;) value = value * s + c[i], sum += std::abs(c[i]);
    const double off = (degree + 1) * error + 2 * (degree + 1) * kUnit * sum;
    return value > off ? 1 : value < -off ? -1 : 0;
  }
  /// False where the first coefficient may be zero, or any number is not finite.
  bool scale() {
    double largest = 0;
    for (int i = 0; i <= degree; ++i) largest = std::max(largest, std::abs(c[i]));
    if (!(std::abs(c[degree]) > 4 * error) || !std::isfinite(largest)) return false;
    for (int i = 0; i <= degree; ++i) c[i] /= largest;
    error = error / largest + kUnit;
    return true;
  }
};

/// The negative remainder of a / b, with what its coefficients may be off by.
Link remainder_of(const Link& a, const Link& b) {
  Link r = a;
  for (int top = a.degree; top >= b.degree; --top) {
    const double q = r.c[top] / b.c[b.degree];
    const double off_q =
        (r.error + std::abs(q) * b.error) / (std::abs(b.c[b.degree]) - b.error) + 2 * kUnit * std::abs(q);
    double largest = 0;
    for (int i = 0; i < b.degree; ++i) {
      double& coefficient = r.c[top - b.degree + i];
      largest = std::max(largest, std::abs(coefficient));
      coefficient -= q * b.c[i];
    }
    r.error += std::abs(q) * b.error + off_q * (1 + b.error) + 2 * kUnit * (largest + std::abs(q));
  }
  r.degree = b.degree - 1;
  for (int i = 0; i <= r.degree; ++i) r.c[i] = -r.c[i];
  return r;
}

/// Sturm's chain of a polynomial [Sturm1829]: of the coefficients as they are, which belong to one that is as
/// good as the true one (RayPolynomial::error). Errors are those of the chain's own arithmetic.
class SturmChain {
 public:
  explicit SturmChain(const RayPolynomial& p) {
    links_[0].degree = p.degree;
    std::copy_n(p.c, p.degree + 1, links_[0].c);
    sound_ = links_[0].scale();
    Link& slope = links_[1];
    slope.degree = p.degree - 1;
    for (int i = 0; i < p.degree; ++i) slope.c[i] = (i + 1) * links_[0].c[i + 1];
    slope.error = p.degree * (links_[0].error + kUnit);
    sound_ = sound_ && slope.scale();
    for (count_ = 2; sound_ && links_[count_ - 1].degree > 0; ++count_) {
      links_[count_] = remainder_of(links_[count_ - 2], links_[count_ - 1]);
      sound_ = links_[count_].scale();  // nothing but error: a double root
    }
  }

  /// Whether all of its leading coefficients are known not to be zero.
  bool sound() const { return sound_; }

  /// How often the sign changes along the chain at `s`; nothing where that is open.
  std::optional<int> changes_at(double s) const {
    int changes = 0, last = links_[0].sign_at(s);
    if (last == 0) return std::nullopt;
    for (int i = 1; i < count_; ++i) {
      int sign = links_[i].sign_at(s);
      if (sign == 0) {
        // Between two opposite signs there is one change, whatever it is.
        if (i + 1 == count_ || links_[i + 1].sign_at(s) != -last) return std::nullopt;
        sign = last;
      }
      changes += sign != last;
      last = sign;
    }
    return changes;
  }

 private:
  Link links_[kMaxRayDegree + 1];
  int count_ = 0;
  bool sound_ = false;
};

}  // namespace

std::optional<double> certain_root_by_sturm(const RayPolynomial& p, bool any) {
  const SturmChain chain(p);
  if (!chain.sound()) return std::nullopt;
  double low = -1, high = 1;
  std::optional<int> at_low = chain.changes_at(low), at_high = chain.changes_at(high);
  if (!at_low || !at_high) return std::nullopt;
  if (*at_low == *at_high) return kNoRoot;
  if (any) return high;
  while (*at_low - *at_high > 1) {
    if (high - low < 0x1p-40) return std::nullopt;
    // Not the middle alone: a root may lie there.
    double between = 0.5 * (low + high);
    std::optional<int> at_between = chain.changes_at(between);
    if (!at_between) {
      between = low + 0.4375 * (high - low);
      at_between = chain.changes_at(between);
    }
    if (!at_between) return std::nullopt;
    if (*at_low > *at_between) {
      high = between, at_high = at_between;
    } else {
      low = between, at_low = at_between;
    }
  }
  return refine_root(p, low, high);
}

double first_root_by_sturm(const RayPolynomial& p, bool any) {
  const std::optional<double> root = certain_root_by_sturm(p, any);
  return root ? *root : first_root_by_intervals(p, any);
}

}  // namespace tessera::render::TESSERA_ISA
