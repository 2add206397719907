#include "photometry/units/weighting.h"

#include <cstddef>

#include "spectra/observer/action_spectrum.h"

namespace tessera::photometry {

double band_weight(Weighting weighting, double from_nm, double to_nm) {
  switch (weighting) {
    case Weighting::kRadiometric:
      return to_nm - from_nm;
    case Weighting::kPhotopic:
      return kLumensPerWatt * spectra::photopic().integral(from_nm, to_nm);
    case Weighting::kScotopic:
      return kScotopicLumensPerWatt * spectra::scotopic().integral(from_nm, to_nm);
    case Weighting::kMelanopic:
      break;
  }
  return spectra::melanopic().integral(from_nm, to_nm) / kMelanopicWattsPerLumen;
}

double weighted(Weighting weighting, std::span<const double> bands, double from_nm, double width_nm) {
  double sum = 0;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const double begin = from_nm + width_nm * static_cast<double>(i);
    sum += bands[i] * band_weight(weighting, begin, begin + width_nm);
  }
  return sum;
}

}  // namespace tessera::photometry
