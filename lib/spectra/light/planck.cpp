#include "spectra/light/planck.h"

#include <cmath>

namespace tessera::spectra {

double relative_planck(double nm, double kelvin) {
  constexpr double kSecondRadiationNmK = 1.438776877e7;
  constexpr double kWienX = 4.965114231744276;
  const double x = kSecondRadiationNmK / (nm * kelvin);
  if (x > 700) return 0;
  return std::pow(x / kWienX, 5) * std::expm1(kWienX) / std::expm1(x);
}

}  // namespace tessera::spectra
