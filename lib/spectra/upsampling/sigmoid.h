// Reflectances as sigmoids of quadratic polynomials [Jakob & Hanika 2019]: three floats, as large as RGB.
#pragma once

#include <algorithm>
#include <cmath>

namespace tessera::spectra {

/// The reflectance at l nanometres is 1/2 + x / (2 sqrt(1 + x^2)), where x = (c0 t + c1) t + c2 and
/// t = (l - 595) / 235, which is -1 at 360 nm and 1 at 830 nm; beyond, it is as there. It lies in [0, 1] at
/// every wavelength, also in floats.
struct SigmoidCoefficients {
  float c0 = 0, c1 = 0, c2 = 0;
};

inline constexpr float kSigmoidMiddleNm = 595, kSigmoidHalfWidthNm = 235;

inline float sigmoid(float x) {
  const float root = std::sqrt(1 + x * x);
  // One number in two ways: each cancels where the other does not.
  return x < 0 ? 0.5f / (root * (root - x)) : 0.5f + 0.5f * x / root;
}

/// Reflectance at a wavelength in nanometres.
inline float value(const SigmoidCoefficients& coefficients, float nm) {
  const float t = std::clamp((nm - kSigmoidMiddleNm) / kSigmoidHalfWidthNm, -1.0f, 1.0f);
  return sigmoid((coefficients.c0 * t + coefficients.c1) * t + coefficients.c2);
}

/// The number whose sigmoid is a reflectance in [0, 1].
double inverse_sigmoid(double reflectance);

/// The same reflectance at all wavelengths.
SigmoidCoefficients constant_sigmoid(float reflectance);

}  // namespace tessera::spectra
