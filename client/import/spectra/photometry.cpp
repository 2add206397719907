#include "import/spectra/photometry.h"

#include <algorithm>
#include <cmath>

#include "import/spectra/cie1931.h"
#include "tables/cie1931.h"

namespace tessera::client {

double luminance(const std::function<double(double)>& spectrum) {
  double sum = 0, white = 0;
  for (double nm = tables::kCieFirstNm; nm <= tables::kCieLastNm; ++nm) {
    const double y = cie1931(nm)[1];
    sum += y * spectrum(nm);
    white += y;
  }
  return sum / white;
}

double luminance(const SpectrumTable& spectrum) {
  return luminance([&](double nm) { return evaluate(spectrum, nm); });
}

double evaluate(const SpectrumTable& spectrum, double wavelength_nm) {
  const auto& nm = spectrum.wavelengths_nm;
  if (nm.empty()) return 0;
  const std::size_t above =
      std::upper_bound(nm.begin(), nm.end(), static_cast<float>(wavelength_nm)) - nm.begin();
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
