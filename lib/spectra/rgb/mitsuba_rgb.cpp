#include "spectra/rgb/mitsuba_rgb.h"

#include "spectra/light/daylight.h"
#include "spectra/observer/cie1931.h"

namespace tessera::spectra {
namespace {

// Integral of the CIE function y, and of y times D65 relative to it, as Mitsuba 3 has them.
constexpr double kIntegralOfY = 106.7502593994140625;
constexpr double kMeanOfD65 = 98.99741751876255;

}  // namespace

Triple mitsuba_rgb_from_xyz(const Triple& xyz) {
  constexpr double kMatrix[3][3] = {
      {3.240479, -1.537150, -0.498535}, {-0.969256, 1.875991, 0.041556}, {0.055648, -0.204043, 1.057311}};
  Triple rgb;
  for (std::size_t r = 0; r < 3; ++r)
    rgb[r] = kMatrix[r][0] * xyz[0] + kMatrix[r][1] * xyz[1] + kMatrix[r][2] * xyz[2];
  return rgb;
}

Triple mitsuba_rgb(const Curve& spectrum, SeenUnder light) {
  constexpr int kSteps = 1000;
  static const Curve d65 = illuminant_d65();
  Triple xyz = {0, 0, 0};
  for (int i = 0; i < kSteps; ++i) {
    const double nm = kCieFirstNm + i / (kSteps - 1.0) * (kCieLastNm - kCieFirstNm);
    if (nm < spectrum.nm.front() || nm > spectrum.nm.back()) continue;
    double value = spectrum.at(nm);
    if (light == SeenUnder::kD65) value *= d65.at(nm) / kMeanOfD65;
    const Triple matching = cie1931().at(nm);
    for (std::size_t c = 0; c < 3; ++c) xyz[c] += value * matching[c];
  }
  for (double& c : xyz) c *= (kCieLastNm - kCieFirstNm) / (kSteps * kIntegralOfY);
  return mitsuba_rgb_from_xyz(xyz);
}

}  // namespace tessera::spectra
