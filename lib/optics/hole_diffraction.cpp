#include "optics/hole_diffraction.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace tessera::optics {

namespace {

using std::numbers::pi;

/// Bessel functions of orders 0, 1, 2, ... at one place, until they vanish: Miller's recurrence from high
/// orders down, made absolute by J0 + 2 (J2 + J4 + ...) = 1.
class BesselOrders {
 public:
  void set(double x) {
    values_.assign(2, 0);
    values_[0] = 1, values_[1] = x / 2;
    if (x < 1e-6) return;
    const auto most = static_cast<std::size_t>(x + 12 * std::cbrt(x) + 24);
    values_.assign(most + 2, 0);
    values_[most] = 1e-250;
    const double inverse = 2 / x;
    double sum = 0;
    for (std::size_t n = most; n > 0; --n) {
      values_[n - 1] = inverse * static_cast<double>(n) * values_[n] - values_[n + 1];
      if (n % 2 == 1 && n > 1) sum += 2 * values_[n - 1];
      if (std::abs(values_[n - 1]) > 1e200) {
        for (std::size_t i = n - 1; i <= most; ++i) values_[i] *= 1e-200;
        sum *= 1e-200;
      }
    }
    sum += values_[0];
    for (double& value : values_) value /= sum;
  }

  /// The sum of (-1)^s ratio^(first + 2s) J_(first + 2s), which are Lommel's functions for ratios up to 1.
  double alternating(double ratio, std::size_t first) const {
    const double step = -ratio * ratio;
    double power = std::pow(ratio, static_cast<double>(first)), sum = 0;
    for (std::size_t n = first; n < values_.size() && std::abs(power) > 1e-18; n += 2, power *= step)
      sum += power * values_[n];
    return sum;
  }

 private:
  std::vector<double> values_;
};

double irradiance(double u, double radius, BesselOrders& bessel) {
  const double v = u * radius;
  bessel.set(v);
  if (radius >= 1) {
    const double u1 = bessel.alternating(1 / radius, 1), u2 = bessel.alternating(1 / radius, 2);
    return u1 * u1 + u2 * u2;
  }
  const double v0 = bessel.alternating(radius, 0), v1 = bessel.alternating(radius, 1);
  const double phase = (u + v * radius) / 2;
  return 1 + v0 * v0 + v1 * v1 - 2 * v0 * std::cos(phase) - 2 * v1 * std::sin(phase);
}

}  // namespace

double hole_irradiance(double fresnel_number, double radius) {
  BesselOrders bessel;
  return irradiance(2 * pi * fresnel_number, radius, bessel);
}

std::vector<double> light_within_hole(double fresnel_number, std::span<const double> radii) {
  // Simpson's rule takes several steps in each of the pattern's shortest waves.
  constexpr double kStepsInWave = 6;
  const double u = 2 * pi * fresnel_number;
  std::vector<double> parts;
  BesselOrders bessel;
  const auto at = [&](double radius) { return 2 * radius * irradiance(u, radius, bessel); };
  double sum = 0, before = 0, from = 0;
  for (const double to : radii) {
    const auto steps = static_cast<int>(std::ceil((to - from) * u / pi * kStepsInWave));
    const double step = (to - from) / std::max(steps, 1);
    for (int i = 0; i < std::max(steps, 1); ++i) {
      const double middle = at(from + (i + .5) * step), end = at(from + (i + 1) * step);
      sum += step / 6 * (before + 4 * middle + end);
      before = end;
    }
    parts.push_back(sum);
    from = to;
  }
  // Energy is conserved.
  const double all = sum + light_beyond_hole(fresnel_number, radii.back());
  for (double& part : parts) part /= all;
  return parts;
}

// There, J_n of one parity differ in sign alone, Lommel's series are geometric, and the mean of a squared
// Bessel function is 1 / (pi v).
double light_beyond_hole(double fresnel_number, double radius) {
  return radius / (pi * pi * fresnel_number * (radius * radius - 1));
}

}  // namespace tessera::optics
