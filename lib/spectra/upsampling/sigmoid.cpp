#include "spectra/upsampling/sigmoid.h"

#include <algorithm>

namespace tessera::spectra {

double inverse_sigmoid(double reflectance) {
  // Its square is a float, and its sigmoid is 0 or 1.
  constexpr double kInfinite = 1e18;
  const double product = reflectance * (1 - reflectance);
  if (!(product > 0)) return reflectance > 0.5 ? kInfinite : -kInfinite;
  return std::clamp((reflectance - 0.5) / std::sqrt(product), -kInfinite, kInfinite);
}

SigmoidCoefficients constant_sigmoid(float reflectance) {
  return {0, 0, static_cast<float>(inverse_sigmoid(reflectance))};
}

}  // namespace tessera::spectra
