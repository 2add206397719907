// A rough dielectric boundary in scalar double precision, written apart from the kernels, as the reference of
// their tests: GGX normals by the method of [Heitz 2018], masking by Lambda functions of the tangent as in
// [Heitz 2014].
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include "support/kernel/bsdf_cases.h"

namespace tessera::test {

/// Fresnel reflectance at a boundary; `eta` is the index of the far side over that of the near side.
inline double fresnel_reflectance(double cos_i, double eta) {
  const double sin2_t = (1 - cos_i * cos_i) / (eta * eta);
  if (sin2_t >= 1) return 1;
  const double cos_t = std::sqrt(1 - sin2_t);
  const double s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t),
               p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  return 0.5 * (s * s + p * p);
}

/// Directions on the near side have z > 0.
class RoughBoundary {
 public:
  RoughBoundary(double alpha_x, double alpha_y, double eta) : ax_(alpha_x), ay_(alpha_y), eta_(eta) {}

  double lambda(const Direction& w) const {
    const double z2 = w[2] * w[2];
    return z2 == 0 ? 1e30
                   : 0.5 * (std::sqrt(1 + (ax_ * ax_ * w[0] * w[0] + ay_ * ay_ * w[1] * w[1]) / z2) - 1);
  }

  double density(const Direction& m) const {
    const double slope = m[0] * m[0] / (ax_ * ax_) + m[1] * m[1] / (ay_ * ay_) + m[2] * m[2];
    return 1 / (M_PI * ax_ * ay_ * slope * slope);
  }

  /// f(wo, wi) of reflection on the near side.
  double reflection(const Direction& wo, const Direction& wi) const {
    Direction m{wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2]};
    const double length = std::sqrt(dot(m, m));
    for (double& x : m) x /= length;
    return fresnel_reflectance(dot(wo, m), eta_) * density(m) / (1 + lambda(wo) + lambda(wi)) /
           (4 * wo[2] * wi[2]);
  }

  struct Scattered {
    Direction w;
    double weight;  // share of the energy, masking included; Fresnel is in the choice
    bool transmitted;
  };

  /// Scatters once light along w; nothing when it would have to scatter again.
  template <class Random>
  std::optional<Scattered> scatter(const Direction& w, Random& random) const {
    std::uniform_real_distribution<double> uniform;
    const Direction m = visible_normal(w, uniform(random), uniform(random));
    const double c = dot(w, m);
    const bool transmitted = uniform(random) >= fresnel_reflectance(c, eta_);
    Scattered out{{}, 0, transmitted};
    const double along = transmitted ? c / eta_ - std::sqrt(1 - (1 - c * c) / (eta_ * eta_)) : 2 * c;
    for (int i = 0; i < 3; ++i) out.w[i] = along * m[i] - w[i] / (transmitted ? eta_ : 1);
    if (transmitted ? out.w[2] >= 0 : out.w[2] <= 0) return std::nullopt;
    out.weight = (1 + lambda(w)) / (1 + lambda(w) + lambda(out.w));
    return out;
  }

 private:
  Direction visible_normal(const Direction& w, double u0, double u1) const {
    Direction v{ax_ * w[0], ay_ * w[1], w[2]};
    const double length = std::sqrt(dot(v, v));
    for (double& x : v) x /= length;
    const double xy = std::hypot(v[0], v[1]);
    const Direction t1 = xy > 0 ? Direction{-v[1] / xy, v[0] / xy, 0} : Direction{1, 0, 0};
    const Direction t2{v[1] * t1[2] - v[2] * t1[1], v[2] * t1[0] - v[0] * t1[2], v[0] * t1[1] - v[1] * t1[0]};
    const double r = std::sqrt(u0), phi = 2 * M_PI * u1, p1 = r * std::cos(phi), s = 0.5 * (1 + v[2]);
    const double p2 = (1 - s) * std::sqrt(1 - p1 * p1) + s * r * std::sin(phi);
    const double p3 = std::sqrt(std::max(0.0, 1 - p1 * p1 - p2 * p2));
    Direction m;
    for (int i = 0; i < 3; ++i) m[i] = p1 * t1[i] + p2 * t2[i] + p3 * v[i];
    m = {ax_ * m[0], ay_ * m[1], std::max(1e-9, m[2])};
    const double norm = std::sqrt(dot(m, m));
    for (double& x : m) x /= norm;
    return m;
  }

  double ax_, ay_, eta_;
};

}  // namespace tessera::test
