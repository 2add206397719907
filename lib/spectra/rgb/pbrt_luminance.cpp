#include "spectra/rgb/pbrt_luminance.h"

#include "spectra/observer/cie1931.h"

namespace tessera::spectra {

double pbrt_luminance(const std::function<double(double)>& spectrum) {
  double sum = 0, white = 0;
  for (double nm = kCieFirstNm; nm <= kCieLastNm; ++nm) {
    const double y = cie1931().at(nm)[1];
    sum += y * spectrum(nm);
    white += y;
  }
  return sum / white;
}

double pbrt_luminance(const Curve& spectrum) {
  return pbrt_luminance([&](double nm) { return spectrum.at(nm); });
}

}  // namespace tessera::spectra
