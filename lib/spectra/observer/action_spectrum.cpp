#include "spectra/observer/action_spectrum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "spectra/observer/cie1931.h"

namespace tessera::spectra {
namespace {

constexpr std::size_t kCount = 81;

constexpr std::array<double, kCount> kScotopic = {
    0.000589, 0.001108, 0.002209,  0.00453,   0.00929,  0.01852,   0.03484,  0.0604,   0.0966,
    0.1436,   0.1998,   0.2625,    0.3281,    0.3931,   0.455,     0.513,    0.567,    0.62,
    0.676,    0.734,    0.793,     0.851,     0.904,    0.949,     0.982,    0.998,    0.997,
    0.975,    0.935,    0.88,      0.811,     0.733,    0.65,      0.564,    0.481,    0.402,
    0.3288,   0.2639,   0.2076,    0.1602,    0.1212,   0.0899,    0.0655,   0.0469,   0.03315,
    0.02312,  0.01593,  0.01088,   0.00737,   0.00497,  0.003335,  0.002235, 0.001497, 0.001005,
    0.000677, 0.000459, 0.0003129, 0.0002146, 0.000148, 0.0001026, 7.15e-5,  5.01e-5,  3.533e-5,
    2.501e-5, 1.78e-5,  1.273e-5,  9.14e-6,   6.6e-6,   4.78e-6,   3.482e-6, 2.546e-6, 1.87e-6,
    1.379e-6, 1.022e-6, 7.6e-7,    5.67e-7,   4.25e-7,  3.2e-7,    2.41e-7,  1.83e-7,  1.39e-7,
};

constexpr std::array<double, kCount> kMelanopic = {
    0.00091816, 0.0016672, 0.0030944, 0.0058804,  0.011428,   0.022811,   0.046155,  0.079477,   0.13724,
    0.1871,     0.25387,   0.32068,   0.40159,    0.474,      0.55371,    0.62965,   0.70805,    0.78522,
    0.86029,    0.91773,   0.96561,   0.99062,    1,          0.99202,    0.96595,   0.9223,     0.86289,
    0.78523,    0.69963,   0.60942,   0.51931,    0.43253,    0.35171,    0.27914,   0.21572,    0.16206,
    0.11853,    0.084346,  0.058701,  0.040009,   0.026875,   0.017862,   0.01179,   0.0077343,  0.0050669,
    0.0033177,  0.002177,  0.0014331, 0.00094731, 0.00062765, 0.00041796, 0.0002798, 0.00018834, 0.00012734,
    8.66e-5,    5.92e-5,   4.07e-5,   2.81e-5,    1.96e-5,    1.36e-5,    9.58e-6,   6.75e-6,    4.79e-6,
    3.41e-6,    2.44e-6,   1.75e-6,   1.27e-6,    9.18e-7,    6.69e-7,    4.9e-7,    3.6e-7,     2.65e-7,
    1.97e-7,    1.46e-7,   1.09e-7,   8.2e-8,     6.17e-8,    4.66e-8,    3.53e-8,   2.69e-8,    2.05e-8,
};

constexpr std::array<double, kCieCount> y_of_observer() {
  std::array<double, kCieCount> y{};
  for (std::size_t i = 0; i < y.size(); ++i) y[i] = kCie1931[i][1];
  return y;
}

constexpr std::array<double, kCieCount> kPhotopic = y_of_observer();

}  // namespace

double ActionSpectrum::at(double wavelength_nm) const {
  if (!(wavelength_nm >= first_nm && wavelength_nm <= last_nm())) return 0;
  const double position = (wavelength_nm - first_nm) / step_nm;
  const std::size_t index = std::min(static_cast<std::size_t>(position), values.size() - 2);
  const double t = position - static_cast<double>(index);
  return (1 - t) * values[index] + t * values[index + 1];
}

double ActionSpectrum::integral(double from_nm, double to_nm) const {
  const double from = std::max(from_nm, first_nm), to = std::min(to_nm, last_nm());
  if (!(from < to)) return 0;
  double sum = 0, left = from;
  // From knot to knot, where the function is a line.
  for (auto knot = static_cast<std::size_t>(std::floor((from - first_nm) / step_nm)) + 1; left < to; ++knot) {
    const double right = std::min(to, first_nm + step_nm * static_cast<double>(knot));
    sum += (right - left) * at(0.5 * (left + right));
    left = right;
  }
  return sum;
}

const ActionSpectrum& photopic() {
  static constexpr ActionSpectrum spectrum{kCieFirstNm, kCieStepNm, kPhotopic};
  return spectrum;
}

const ActionSpectrum& scotopic() {
  static constexpr ActionSpectrum spectrum{380, 5, kScotopic};
  return spectrum;
}

const ActionSpectrum& melanopic() {
  static constexpr ActionSpectrum spectrum{380, 5, kMelanopic};
  return spectrum;
}

}  // namespace tessera::spectra
