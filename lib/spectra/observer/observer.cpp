#include "spectra/observer/observer.h"

#include <algorithm>
#include <cstddef>

#include "spectra/observer/cie1931.h"

namespace tessera::spectra {

Triple Observer::at(double wavelength_nm) const {
  if (!(wavelength_nm >= first_nm && wavelength_nm <= last_nm())) return {0, 0, 0};
  const double position = (wavelength_nm - first_nm) / step_nm;
  const std::size_t index = std::min(static_cast<std::size_t>(position), rows.size() - 2);
  const Triple &low = rows[index], &high = rows[index + 1];
  const double t = position - static_cast<double>(index);
  return {(1 - t) * low[0] + t * high[0], (1 - t) * low[1] + t * high[1], (1 - t) * low[2] + t * high[2]};
}

const Observer& cie1931() {
  static constexpr Observer observer{kCieFirstNm, kCieStepNm, kCie1931};
  return observer;
}

}  // namespace tessera::spectra
