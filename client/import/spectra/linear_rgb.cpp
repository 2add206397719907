#include "import/spectra/linear_rgb.h"

#include "import/spectra/cie1931.h"
#include "import/spectra/photometry.h"
#include "import/spectra/tables.h"
#include "tables/cie1931.h"

namespace tessera::client {
namespace {

// Integral of the CIE function y, and of y times D65 relative to it, as Mitsuba 3 has them.
constexpr double kIntegralOfY = 106.7502593994140625;
constexpr double kMeanOfD65 = 98.99741751876255;

}  // namespace

std::array<double, 3> rec709_from_xyz(const std::array<double, 3>& xyz) {
  constexpr double kMatrix[3][3] = {
      {3.240479, -1.537150, -0.498535}, {-0.969256, 1.875991, 0.041556}, {0.055648, -0.204043, 1.057311}};
  std::array<double, 3> rgb;
  for (int r = 0; r < 3; ++r)
    rgb[r] = kMatrix[r][0] * xyz[0] + kMatrix[r][1] * xyz[1] + kMatrix[r][2] * xyz[2];
  return rgb;
}

std::array<double, 3> linear_rgb(const SpectrumTable& spectrum, SeenUnder light) {
  constexpr int kSteps = 1000;
  static const SpectrumTable d65 = *find_illuminant("D65");
  std::array<double, 3> xyz = {0, 0, 0};
  for (int i = 0; i < kSteps; ++i) {
    const double nm = tables::kCieFirstNm + i / (kSteps - 1.0) * (tables::kCieLastNm - tables::kCieFirstNm);
    if (nm < spectrum.wavelengths_nm.front() || nm > spectrum.wavelengths_nm.back()) continue;
    double value = evaluate(spectrum, nm);
    if (light == SeenUnder::kD65) value *= evaluate(d65, nm) / kMeanOfD65;
    const std::array<double, 3> matching = cie1931(nm);
    for (int c = 0; c < 3; ++c) xyz[c] += value * matching[c];
  }
  for (double& c : xyz) c *= (tables::kCieLastNm - tables::kCieFirstNm) / (kSteps * kIntegralOfY);
  return rec709_from_xyz(xyz);
}

}  // namespace tessera::client
