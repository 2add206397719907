#include "spectra/light/planck.h"

#include <cmath>

namespace tessera::spectra {

namespace {
constexpr double kSecondRadiationNmK = 1.438776877e7;
}  // namespace

double relative_planck(double nm, double kelvin) {
  constexpr double kWienX = 4.965114231744276;
  const double x = kSecondRadiationNmK / (nm * kelvin);
  if (x > 700) return 0;
  return std::pow(x / kWienX, 5) * std::expm1(kWienX) / std::expm1(x);
}

double planck(double nm, double kelvin) {
  constexpr double kFirstRadiation = 1.191042972e20;  // 2 h c^2, W nm^4 / (m^2 sr)
  const double x = kSecondRadiationNmK / (nm * kelvin);
  return x > 700 ? 0 : kFirstRadiation / (std::pow(nm, 5) * std::expm1(x));
}

}  // namespace tessera::spectra
