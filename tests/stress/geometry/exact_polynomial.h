// Polynomials along rays in arithmetic of 256 bits, and their first roots by Sturm's theorem: the judge of
// implicit surfaces.
#pragma once

#include <gmpxx.h>

#include <array>
#include <optional>
#include <vector>

#include "render/shape/implicit/implicit_record.h"
#include "support/kernel/double_point.h"

namespace tessera::test {

using Wide256 = mpf_class;
inline const bool kBits256 = (mpf_set_default_prec(256), true);
inline Wide256 wide256(double x) { return Wide256(x); }

using Series256 = std::vector<Wide256>;

inline Wide256 value_of(const Series256& p, const Wide256& s) {
  Wide256 value = p.back();
  for (std::size_t i = p.size() - 1; i-- > 0;) value = value * s + p[i];
  return value;
}

/// Where a ray is within the ball of a surface, and the polynomial along that part, from -1 to 1.
struct ExactChord {
  Wide256 begin, end;
  Series256 polynomial;

  Wide256 s_of(double t) const { return (wide256(t) - begin) / (end - begin) * 2 - 1; }
};

/// A point (w = 1) or direction (0) in object space.
inline std::array<Wide256, 3> exactly_placed(const render::ImplicitRecord& surface, Point p, int w) {
  std::array<Wide256, 3> r;
  for (std::size_t i = 0; i < 3; ++i) {
    const float* m = surface.object_from_render.m + 4 * i;
    r[i] = wide256(m[0]) * p.x + wide256(m[1]) * p.y + wide256(m[2]) * p.z + wide256(m[3]) * w;
  }
  return r;
}

/// f at a point of render space.
inline Wide256 exact_value(const render::ImplicitRecord& surface, Point p) {
  const auto q = exactly_placed(surface, p, 1);
  const double* coefficient = surface.coefficients.data();
  const int n = surface.degree;
  Wide256 sum = wide256(0);
  for (int i = n; i >= 0; --i) {
    Wide256 in_y = wide256(0);
    for (int j = n - i; j >= 0; --j) {
      Wide256 in_z = wide256(0);
      for (int k = n - i - j; k >= 0; --k) in_z = in_z * q[2] + *coefficient++;
      in_y = in_y * q[1] + in_z;
    }
    sum = sum * q[0] + in_y;
  }
  return sum;
}

inline std::optional<ExactChord> exact_chord(const render::ImplicitRecord& surface, Point origin,
                                             Point direction) {
  const auto o = exactly_placed(surface, origin, 1), d = exactly_placed(surface, direction, 0);
  const auto dot = [](const auto& a, const auto& b) {
    return Wide256(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
  };
  const Wide256 a = dot(d, d), b = dot(o, d), c = dot(o, o) - wide256(surface.radius) * surface.radius;
  const Wide256 square = b * b - a * c;
  if (square <= 0) return std::nullopt;
  const Wide256 root = sqrt(square);
  ExactChord chord{Wide256((-b - root) / a), Wide256((-b + root) / a), {}};
  if (chord.begin < 0) chord.begin = 0;
  if (chord.begin >= chord.end) return std::nullopt;
  std::array<Wide256, 3> middle, half;
  for (std::size_t i = 0; i < 3; ++i) {
    middle[i] = o[i] + d[i] * (chord.begin + chord.end) / 2;
    half[i] = d[i] * (chord.end - chord.begin) / 2;
  }
  const auto multiply = [&](Series256& p, std::size_t axis) {
    if (p.empty()) return;
    p.push_back(p.back() * half[axis]);
    for (std::size_t i = p.size() - 2; i > 0; --i) p[i] = p[i] * middle[axis] + p[i - 1] * half[axis];
    p[0] *= middle[axis];
  };
  const auto add = [](Series256& p, const Series256& q) {
    if (p.size() < q.size()) p.resize(q.size(), wide256(0));
    for (std::size_t i = 0; i < q.size(); ++i) p[i] += q[i];
  };
  const double* coefficient = surface.coefficients.data();
  const int n = surface.degree;
  for (int i = n; i >= 0; --i) {
    multiply(chord.polynomial, 0);
    Series256 in_y;
    for (int j = n - i; j >= 0; --j) {
      multiply(in_y, 1);
      Series256 in_z;
      for (int k = n - i - j; k >= 0; --k) {
        multiply(in_z, 2);
        if (const double value = *coefficient++; value != 0) add(in_z, {wide256(value)});
      }
      add(in_y, in_z);
    }
    add(chord.polynomial, in_y);
  }
  chord.polynomial.resize(static_cast<std::size_t>(n) + 1, wide256(0));
  return chord;
}

/// Counts and finds roots within [-1, 1]. Coefficients below 2^-200 of the largest are zero.
class Sturm256 {
 public:
  explicit Sturm256(Series256 p) {
    trim(p);
    chain_.push_back(std::move(p));
    if (chain_[0].size() < 2) return;
    Series256 slope;
    for (std::size_t i = 1; i < chain_[0].size(); ++i) slope.push_back(chain_[0][i] * static_cast<int>(i));
    trim(slope);
    chain_.push_back(std::move(slope));
    while (chain_.back().size() > 1) {
      Series256 r = chain_[chain_.size() - 2];
      const Series256& b = chain_.back();
      while (r.size() >= b.size()) {
        const Wide256 q = r.back() / b.back();
        for (std::size_t i = 0; i < b.size(); ++i) r[r.size() - b.size() + i] -= q * b[i];
        r.pop_back();
      }
      for (Wide256& c : r) c = -c;
      trim(r, 1);
      if (r.empty()) break;
      chain_.push_back(std::move(r));
    }
  }

  /// The upper end of an interval of 2^-44 that holds the first root, or nothing.
  std::optional<double> first_root() const {
    double low = -1, high = 1;
    const int at_low = changes(low);
    if (at_low == changes(high)) return std::nullopt;
    while (high - low > 0x1p-44) {
      const double middle = (low + high) / 2;
      (changes(middle) < at_low ? high : low) = middle;
    }
    return high;
  }

 private:
  /// Scales to a largest coefficient of 1; those that are nothing but rounding of numbers of `scale` go.
  static void trim(Series256& p, double scale = 0) {
    Wide256 largest = wide256(0);
    for (const Wide256& c : p) {
      if (abs(c) > largest) largest = abs(c);
    }
    const Wide256 least = (largest > scale ? largest : wide256(scale)) * wide256(0x1p-200);
    while (!p.empty() && abs(p.back()) <= least) p.pop_back();
    if (largest > 0) {
      for (Wide256& c : p) c /= largest;
    }
  }
  int changes(double s) const {
    int count = 0, last = 0;
    for (const Series256& p : chain_) {
      if (p.empty()) continue;
      const int sign = sgn(value_of(p, wide256(s)));
      count += sign != 0 && last != 0 && sign != last;
      if (sign != 0) last = sign;
    }
    return count;
  }

  std::vector<Series256> chain_;
};

}  // namespace tessera::test
