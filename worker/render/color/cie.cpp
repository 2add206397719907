#include "render/color/cie.h"

#include <algorithm>
#include <cmath>

#include "tables/cie1931.h"
#include "tables/illuminant_d65.h"

namespace tessera::render {
namespace {

using tables::CieRow, tables::kCieCount, tables::kCieMatching, tables::kIlluminantD65;

struct Triple {
  double v[3] = {0, 0, 0};
};

double wavelength_nm(int row) { return tables::kCieFirstNm + tables::kCieStepNm * row; }

double illuminant_d65(int row) {
  // Two rows of the colour-matching functions for each of these, whose first are in the ultraviolet.
  constexpr double kFirst = (tables::kCieFirstNm - tables::kD65FirstNm) / tables::kD65StepNm;
  const auto i = static_cast<std::size_t>(kFirst) + static_cast<std::size_t>(row / 2);
  return row % 2 == 0 ? kIlluminantD65[i] : 0.5 * (kIlluminantD65[i] + kIlluminantD65[i + 1]);
}

/// Linear Rec.709 of a colour in CIE XYZ [ITU-R BT.709; IEC 61966-2-1].
Triple rec709_from_xyz(double x, double y, double z) {
  return {{3.2404542 * x - 1.5371385 * y - 0.4985314 * z, -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
           0.0556434 * x - 0.2040259 * y + 1.0572252 * z}};
}

/// Linear Rec.709 of the spectrum f(row), normalised so that f = 1 has luminance 1.
template <class F>
Triple integrate(F&& f) {
  double x = 0, y = 0, z = 0, y_of_one = 0;
  for (int row = 0; row < kCieCount; ++row) {
    const CieRow& m = kCieMatching[static_cast<std::size_t>(row)];
    const double value = f(row);
    x += m.x * value;
    y += m.y * value;
    z += m.z * value;
    y_of_one += m.y;
  }
  return rec709_from_xyz(x / y_of_one, y / y_of_one, z / y_of_one);
}

template <class F>
double luminance(F&& f) {
  double y = 0, y_of_one = 0;
  for (int row = 0; row < kCieCount; ++row) {
    y += kCieMatching[static_cast<std::size_t>(row)].y * f(row);
    y_of_one += kCieMatching[static_cast<std::size_t>(row)].y;
  }
  return y / y_of_one;
}

Rgb clamped(const Triple& t, double high) {
  // Written so that NaN becomes zero.
  const auto c = [high](double v) { return v > 0 ? static_cast<float>(std::min(v, high)) : 0.0f; };
  return {c(t.v[0]), c(t.v[1]), c(t.v[2])};
}
Rgb in_gamut(const Triple& t) { return clamped(t, 3e38); }

/// Each channel of the reflectance spectrum f(row) under D65, relative to a perfect white.
template <class F>
Triple under_d65(F&& f) {
  const Triple white = integrate(illuminant_d65);
  Triple t = integrate([&](int row) { return f(row) * illuminant_d65(row); });
  for (int i = 0; i < 3; ++i) t.v[i] /= white.v[i];
  return t;
}

/// Planck's law relative to its own maximum, which Wien's displacement law places at x = 4.9651142 [CODATA
/// 2018].
double relative_planck(double nm, double kelvin) {
  constexpr double kSecondRadiationNmK = 1.438776877e7;
  constexpr double kWienX = 4.965114231744276;
  const double x = kSecondRadiationNmK / (nm * kelvin);
  if (x > 700) return 0;
  return std::pow(x / kWienX, 5) * std::expm1(kWienX) / std::expm1(x);
}

/// The mean of `curve` over what one channel sees under D65. Only the positive part of the channel's response
/// counts, so that the mean lies among the curve's values.
double channel_mean(const SampledCurve& curve, int channel) {
  double sum = 0, weights = 0;
  for (int row = 0; row < kCieCount; ++row) {
    const CieRow& m = kCieMatching[static_cast<std::size_t>(row)];
    const double weight = std::max(rec709_from_xyz(m.x, m.y, m.z).v[channel], 0.0) * illuminant_d65(row);
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

double SampledCurve::at(double wavelength) const {
  const std::size_t n = std::min(nm.size(), value.size());
  if (n == 0) return 0;
  const auto end = nm.begin() + static_cast<std::ptrdiff_t>(n);
  const auto upper = static_cast<std::size_t>(
      std::upper_bound(nm.begin(), end, static_cast<float>(wavelength)) - nm.begin());
  if (upper == 0) return value[0];
  if (upper == n) return value[n - 1];
  const double t = (wavelength - nm[upper - 1]) / (double{nm[upper]} - nm[upper - 1]);
  return value[upper - 1] + std::clamp(t, 0.0, 1.0) * (double{value[upper]} - value[upper - 1]);
}

Rgb emission_rgb(const SampledCurve& spectrum) {
  return in_gamut(integrate([&](int row) { return spectrum.at(wavelength_nm(row)); }));
}

Rgb reflectance_rgb(const SampledCurve& spectrum) {
  return clamped(under_d65([&](int row) { return spectrum.at(wavelength_nm(row)); }), 1);
}

std::vector<ReflectanceShare> reflectance_shares() {
  constexpr int kSteps = 5;
  std::vector<ReflectanceShare> shares;
  std::array<double, 3> sums{};
  for (int i = 0; i <= (kCieCount - 1) * kSteps; ++i) {
    const int row = std::min(i / kSteps, kCieCount - 2);
    const double t = static_cast<double>(i) / kSteps - row;
    const CieRow &a = kCieMatching[static_cast<std::size_t>(row)],
                 &b = kCieMatching[static_cast<std::size_t>(row + 1)];
    const double light = std::lerp(illuminant_d65(row), illuminant_d65(row + 1), t);
    const Triple rgb =
        rec709_from_xyz(std::lerp(a.x, b.x, t), std::lerp(a.y, b.y, t), std::lerp(a.z, b.z, t));
    ReflectanceShare& share = shares.emplace_back(tables::kCieFirstNm + tables::kCieStepNm * i / kSteps);
    for (std::size_t c = 0; c < 3; ++c) sums[c] += share.rgb[c] = rgb.v[c] * light;
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

double emission_luminance(const SampledCurve& spectrum) {
  return luminance([&](int row) { return spectrum.at(wavelength_nm(row)); });
}

double blackbody_luminance(float kelvin) {
  if (!(kelvin > 0)) return 0;
  return luminance([&](int row) { return relative_planck(wavelength_nm(row), kelvin); });
}

double normal_reflectance(double eta, double k) {
  const double low = (eta - 1) * (eta - 1) + k * k, high = (eta + 1) * (eta + 1) + k * k;
  return low / high;
}

ConductorRgb conductor_rgb(const SampledCurve& eta, const SampledCurve& k) {
  const Triple reflectance = under_d65([&](int row) {
    const double nm = wavelength_nm(row);
    return normal_reflectance(eta.at(nm), k.at(nm));
  });
  EtaK index[3];
  for (int i = 0; i < 3; ++i)
    index[i] = index_with_reflectance(std::max(channel_mean(eta, i), 1e-3),
                                      std::clamp(reflectance.v[i], 0.0, 0.9999));
  const auto f = [](double v) { return static_cast<float>(v); };
  return {{f(index[0].eta), f(index[1].eta), f(index[2].eta)}, {f(index[0].k), f(index[1].k), f(index[2].k)}};
}

float dielectric_eta(const SampledCurve& eta) { return static_cast<float>(eta.at(589.3)); }

}  // namespace tessera::render
