// Vectors of doubles, for what is computed once a scene.
#pragma once

#include <cmath>
#include <cstddef>

namespace tessera::render::vec64 {

struct Vec {
  double v[3] = {0, 0, 0};

  double& operator[](std::size_t i) { return v[i]; }
  double operator[](std::size_t i) const { return v[i]; }
};

inline Vec operator+(const Vec& a, const Vec& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vec operator-(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vec operator*(const Vec& a, double s) { return {a[0] * s, a[1] * s, a[2] * s}; }
inline double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double length(const Vec& a) { return std::sqrt(dot(a, a)); }
inline Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
/// The z axis for a vector without length.
inline Vec unit(const Vec& a) {
  const double l = length(a);
  return l > 0 ? a * (1 / l) : Vec{0, 0, 1};
}
inline Vec vec(const float* p) { return {p[0], p[1], p[2]}; }

}  // namespace tessera::render::vec64
