#include "spectra/rgb/scene_rgb.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "spectra/light/daylight.h"
#include "spectra/light/planck.h"
#include "spectra/matter/metals.h"
#include "spectra/observer/cie1931.h"

namespace tessera::spectra {
namespace {

double wavelength_nm(int row) { return kCieFirstNm + kCieStepNm * row; }

double d65_at(int row) {
  // Two rows of the colour-matching functions for each of these, whose first are in the ultraviolet.
  constexpr double kFirst = (kCieFirstNm - kDaylightFirstNm) / kDaylightStepNm;
  const auto i = static_cast<std::size_t>(kFirst) + static_cast<std::size_t>(row / 2);
  return row % 2 == 0 ? kD65Power[i] : 0.5 * (kD65Power[i] + kD65Power[i + 1]);
}

/// Linear Rec.709 of a colour in CIE XYZ [ITU-R BT.709; IEC 61966-2-1].
Triple rec709_from_xyz(double x, double y, double z) {
  return {3.2404542 * x - 1.5371385 * y - 0.4985314 * z, -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
          0.0556434 * x - 0.2040259 * y + 1.0572252 * z};
}

/// Linear Rec.709 of the spectrum f(row), normalised so that f = 1 has luminance 1.
template <class F>
Triple integrate(F&& f) {
  double x = 0, y = 0, z = 0, y_of_one = 0;
  for (int row = 0; row < kCieCount; ++row) {
    const Triple& m = kCie1931[static_cast<std::size_t>(row)];
    const double value = f(row);
    x += m[0] * value;
    y += m[1] * value;
    z += m[2] * value;
    y_of_one += m[1];
  }
  return rec709_from_xyz(x / y_of_one, y / y_of_one, z / y_of_one);
}

template <class F>
double luminance(F&& f) {
  double y = 0, y_of_one = 0;
  for (int row = 0; row < kCieCount; ++row) {
    y += kCie1931[static_cast<std::size_t>(row)][1] * f(row);
    y_of_one += kCie1931[static_cast<std::size_t>(row)][1];
  }
  return y / y_of_one;
}

Rgb clamped(const Triple& t, double high) {
  // Written so that NaN becomes zero.
  const auto c = [high](double v) { return v > 0 ? static_cast<float>(std::min(v, high)) : 0.0f; };
  return {c(t[0]), c(t[1]), c(t[2])};
}
Rgb in_gamut(const Triple& t) { return clamped(t, 3e38); }

/// Each channel of the reflectance spectrum f(row) under D65, relative to a perfect white.
template <class F>
Triple under_d65(F&& f) {
  const Triple white = integrate(d65_at);
  Triple t = integrate([&](int row) { return f(row) * d65_at(row); });
  for (int i = 0; i < 3; ++i) t[i] /= white[i];
  return t;
}

/// The mean of `curve` over what one channel sees under D65. Only the positive part of the channel's response
/// counts, so that the mean lies among the curve's values.
double channel_mean(const Curve& curve, int channel) {
  double sum = 0, weights = 0;
  for (int row = 0; row < kCieCount; ++row) {
    const Triple& m = kCie1931[static_cast<std::size_t>(row)];
    const double weight = std::max(rec709_from_xyz(m[0], m[1], m[2])[channel], 0.0) * d65_at(row);
    sum += weight * curve.at(wavelength_nm(row));
    weights += weight;
  }
  return sum / weights;
}

struct EtaK {
  double eta, k;
};

/// The index with real part `eta`, or as near as can be, that reflects `reflectance` at normal incidence.
EtaK index_with_reflectance(double eta, double reflectance) {
  const double root = std::sqrt(reflectance);
  const double k_squared = (reflectance * (eta + 1) * (eta + 1) - (eta - 1) * (eta - 1)) / (1 - reflectance);
  if (k_squared >= 0) return {eta, std::sqrt(k_squared)};
  // Without absorption this eta alone already reflects more.
  const double dense = (1 + root) / (1 - root);
  return {eta >= 1 ? dense : 1 / dense, 0.0};
}

}  // namespace

Rgb emission_rgb(const Curve& spectrum) {
  return in_gamut(integrate([&](int row) { return spectrum.at(wavelength_nm(row)); }));
}

Rgb reflectance_rgb(const Curve& spectrum) {
  return clamped(under_d65([&](int row) { return spectrum.at(wavelength_nm(row)); }), 1);
}

std::vector<ReflectanceShare> reflectance_shares() {
  constexpr int kSteps = 5;
  std::vector<ReflectanceShare> shares;
  Triple sums{};
  for (int i = 0; i <= (kCieCount - 1) * kSteps; ++i) {
    const int row = std::min(i / kSteps, kCieCount - 2);
    const double t = static_cast<double>(i) / kSteps - row;
    const Triple &a = kCie1931[static_cast<std::size_t>(row)],
                 &b = kCie1931[static_cast<std::size_t>(row + 1)];
    const double light = std::lerp(d65_at(row), d65_at(row + 1), t);
    const Triple rgb =
        rec709_from_xyz(std::lerp(a[0], b[0], t), std::lerp(a[1], b[1], t), std::lerp(a[2], b[2], t));
    ReflectanceShare& share = shares.emplace_back();
    share.nm = kCieFirstNm + kCieStepNm * i / kSteps;
    for (std::size_t c = 0; c < 3; ++c) sums[c] += share.rgb[c] = rgb[c] * light;
  }
  for (ReflectanceShare& share : shares) {
    for (std::size_t c = 0; c < 3; ++c) share.rgb[c] /= sums[c];
  }
  return shares;
}

Rgb blackbody_rgb(float kelvin) {
  if (!(kelvin > 0)) return {};
  return in_gamut(integrate([&](int row) { return relative_planck(wavelength_nm(row), kelvin); }));
}

double emission_luminance(const Curve& spectrum) {
  return luminance([&](int row) { return spectrum.at(wavelength_nm(row)); });
}

double blackbody_luminance(float kelvin) {
  if (!(kelvin > 0)) return 0;
  return luminance([&](int row) { return relative_planck(wavelength_nm(row), kelvin); });
}

ConductorRgb conductor_rgb(const Curve& eta, const Curve& k) {
  const Triple reflectance = under_d65([&](int row) {
    const double nm = wavelength_nm(row);
    return normal_reflectance(eta.at(nm), k.at(nm));
  });
  EtaK index[3];
  for (int i = 0; i < 3; ++i)
    index[i] =
        index_with_reflectance(std::max(channel_mean(eta, i), 1e-3), std::clamp(reflectance[i], 0.0, 0.9999));
  const auto f = [](double v) { return static_cast<float>(v); };
  return {{f(index[0].eta), f(index[1].eta), f(index[2].eta)}, {f(index[0].k), f(index[1].k), f(index[2].k)}};
}

float dielectric_eta(const Curve& eta) { return static_cast<float>(eta.at(589.3)); }

}  // namespace tessera::spectra
