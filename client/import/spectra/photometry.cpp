#include "import/spectra/photometry.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace tessera::client {
namespace {

// CIE 1931 2-degree colour-matching function y [CIE 15:2004], 360 to 830 nm in steps of 5 nm.
constexpr float kMatchingY[] = {
    3.917e-6f,  6.965e-6f,  1.239e-5f,  2.202e-5f,  3.9e-5f,   6.4e-5f,    1.2e-4f,    2.17e-4f,   3.96e-4f,
    6.4e-4f,    1.21e-3f,   2.18e-3f,   4e-3f,      7.3e-3f,   1.16e-2f,   1.684e-2f,  2.3e-2f,    2.98e-2f,
    3.8e-2f,    4.8e-2f,    6e-2f,      7.39e-2f,   9.098e-2f, 0.1126f,    0.13902f,   0.1693f,    0.20802f,
    0.2586f,    0.323f,     0.4073f,    0.503f,     0.6082f,   0.71f,      0.7932f,    0.862f,     0.9148501f,
    0.954f,     0.9803f,    0.9949501f, 1.0f,       0.995f,    0.9786f,    0.952f,     0.9154f,    0.87f,
    0.8163f,    0.757f,     0.6949f,    0.631f,     0.5668f,   0.503f,     0.4412f,    0.381f,     0.321f,
    0.265f,     0.217f,     0.175f,     0.1382f,    0.107f,    8.16e-2f,   6.1e-2f,    4.458e-2f,  3.2e-2f,
    2.32e-2f,   1.7e-2f,    1.192e-2f,  8.21e-3f,   5.723e-3f, 4.102e-3f,  2.929e-3f,  2.091e-3f,  1.484e-3f,
    1.047e-3f,  7.4e-4f,    5.2e-4f,    3.611e-4f,  2.492e-4f, 1.719e-4f,  1.2e-4f,    8.48e-5f,   6e-5f,
    4.24e-5f,   3e-5f,      2.12e-5f,   1.499e-5f,  1.06e-5f,  7.4657e-6f, 5.2578e-6f, 3.7029e-6f, 2.6078e-6f,
    1.8366e-6f, 1.2934e-6f, 9.1093e-7f, 6.4153e-7f, 4.5181e-7f};
constexpr int kFirstNm = 360;
constexpr int kLastNm = 830;
constexpr int kStepNm = 5;
static_assert(std::size(kMatchingY) == (kLastNm - kFirstNm) / kStepNm + 1);

double matching_y(int wavelength_nm) {
  const int index = std::min((wavelength_nm - kFirstNm) / kStepNm, static_cast<int>(std::size(kMatchingY)) - 2);
  const double t = static_cast<double>(wavelength_nm - kFirstNm) / kStepNm - index;
  return (1 - t) * kMatchingY[index] + t * kMatchingY[index + 1];
}

}  // namespace

double luminance(const std::function<double(double)>& spectrum) {
  double sum = 0, white = 0;
  for (int nm = kFirstNm; nm <= kLastNm; ++nm) {
    sum += matching_y(nm) * spectrum(nm);
    white += matching_y(nm);
  }
  return sum / white;
}

double luminance(const SpectrumTable& spectrum) {
  return luminance([&](double nm) { return evaluate(spectrum, nm); });
}

double evaluate(const SpectrumTable& spectrum, double wavelength_nm) {
  const auto& nm = spectrum.wavelengths_nm;
  if (nm.empty()) return 0;
  const std::size_t above = std::upper_bound(nm.begin(), nm.end(), static_cast<float>(wavelength_nm)) - nm.begin();
  if (above == 0) return spectrum.values.front();
  if (above == nm.size()) return spectrum.values.back();
  const double t = (wavelength_nm - nm[above - 1]) / (nm[above] - nm[above - 1]);
  return (1 - t) * spectrum.values[above - 1] + t * spectrum.values[above];
}

double normalized_blackbody(double wavelength_nm, double kelvin) {
  // x = h c / (l k T); Planck's law is x^5 / (exp(x) - 1) up to a constant, at its largest where x = 4.965114
  // (Wien's displacement law).
  constexpr double kSecondRadiationConstantNmK = 1.438776877e7;
  constexpr double kWienX = 4.965114231744276;
  const double x = kSecondRadiationConstantNmK / (wavelength_nm * kelvin);
  const auto planck = [](double t) { return std::pow(t, 5) / std::expm1(t); };
  return planck(x) / planck(kWienX);
}

}  // namespace tessera::client
