// Numbers with N derivatives: automatic differentiation, forwards [Wengert1964]. T is Double or Interval.
#pragma once

#include "render/shape/implicit/interval.h"

namespace tessera::render::TESSERA_ISA {

template <class T, int N>
struct Dual {
  T value;
  T d[N];

  /// A function of this with that value and that derivative.
  TESSERA_INLINE Dual chain(const T& result, const T& slope) const {
    Dual r{result, {}};
    for (int i = 0; i < N; ++i) r.d[i] = slope * d[i];
    return r;
  }
};

template <class T, int N>
TESSERA_INLINE Dual<T, N> constant_like(const Dual<T, N>& a, double value) {
  Dual<T, N> r{constant_like(a.value, value), {}};
  for (int i = 0; i < N; ++i) r.d[i] = constant_like(a.value, 0);
  return r;
}
template <class T, int N>
TESSERA_INLINE Dual<T, N> operator+(const Dual<T, N>& a, const Dual<T, N>& b) {
  Dual<T, N> r{a.value + b.value, {}};
  for (int i = 0; i < N; ++i) r.d[i] = a.d[i] + b.d[i];
  return r;
}
template <class T, int N>
TESSERA_INLINE Dual<T, N> operator-(const Dual<T, N>& a, const Dual<T, N>& b) {
  Dual<T, N> r{a.value - b.value, {}};
  for (int i = 0; i < N; ++i) r.d[i] = a.d[i] - b.d[i];
  return r;
}
template <class T, int N>
TESSERA_INLINE Dual<T, N> operator-(const Dual<T, N>& a) {
  Dual<T, N> r{-a.value, {}};
  for (int i = 0; i < N; ++i) r.d[i] = -a.d[i];
  return r;
}
template <class T, int N>
TESSERA_INLINE Dual<T, N> operator*(const Dual<T, N>& a, const Dual<T, N>& b) {
  Dual<T, N> r{a.value * b.value, {}};
  for (int i = 0; i < N; ++i) r.d[i] = a.d[i] * b.value + a.value * b.d[i];
  return r;
}
template <class T, int N>
TESSERA_INLINE Dual<T, N> operator/(const Dual<T, N>& a, const Dual<T, N>& b) {
  Dual<T, N> r{a.value / b.value, {}};
  for (int i = 0; i < N; ++i) r.d[i] = (a.d[i] - r.value * b.d[i]) / b.value;
  return r;
}
template <class T, int N>
Dual<T, N> square_root(const Dual<T, N>& a) {
  const T root = square_root(a.value);
  return a.chain(root, constant_like(root, 0.5) * inverse_above(root, 0));
}
template <class T, int N>
Dual<T, N> sine(const Dual<T, N>& a) {
  return a.chain(sine(a.value), cosine(a.value));
}
template <class T, int N>
Dual<T, N> cosine(const Dual<T, N>& a) {
  return a.chain(cosine(a.value), -sine(a.value));
}
template <class T, int N>
Dual<T, N> exponential(const Dual<T, N>& a) {
  const T value = exponential(a.value);
  return a.chain(value, value);
}
template <class T, int N>
Dual<T, N> logarithm(const Dual<T, N>& a) {
  return a.chain(logarithm(a.value), inverse_above(a.value, kLeastLog));
}
template <class T, int N>
TESSERA_INLINE Dual<T, N> magnitude(const Dual<T, N>& a) {
  return a.chain(magnitude(a.value), sign_of(a.value));
}
template <class T, int N>
TESSERA_INLINE Dual<T, N> lesser(const Dual<T, N>& a, const Dual<T, N>& b) {
  Dual<T, N> r{lesser(a.value, b.value), {}};
  for (int i = 0; i < N; ++i) r.d[i] = where_less(a.value, b.value, a.d[i], b.d[i]);
  return r;
}
template <class T, int N>
TESSERA_INLINE Dual<T, N> greater(const Dual<T, N>& a, const Dual<T, N>& b) {
  Dual<T, N> r{greater(a.value, b.value), {}};
  for (int i = 0; i < N; ++i) r.d[i] = where_less(b.value, a.value, a.d[i], b.d[i]);
  return r;
}
template <class T, int N>
Dual<T, N> whole_power(const Dual<T, N>& a, int n) {
  if (n == 0) return constant_like(a, 1);
  return a.chain(whole_power(a.value, n), constant_like(a.value, n) * whole_power(a.value, n - 1));
}
template <class T, int N>
Dual<T, N> any_power(const Dual<T, N>& a, const Dual<T, N>& b) {
  const T value = any_power(a.value, b.value), log = logarithm(a.value), inverse = inverse_above(a.value, 0);
  Dual<T, N> r{value, {}};
  for (int i = 0; i < N; ++i) r.d[i] = value * (b.d[i] * log + b.value * a.d[i] * inverse);
  return r;
}
template <class T, int N>
Dual<T, N> noise_of(const Dual<T, N>& x, const Dual<T, N>& y, const Dual<T, N>& z) {
  T gradient[3];
  Dual<T, N> r{noise_of(x.value, y.value, z.value, gradient), {}};
  for (int i = 0; i < N; ++i) r.d[i] = gradient[0] * x.d[i] + gradient[1] * y.d[i] + gradient[2] * z.d[i];
  return r;
}

}  // namespace tessera::render::TESSERA_ISA
