#include "import/spectra/cie1931.h"

#include <algorithm>
#include <cstddef>

#include "tables/cie1931.h"

namespace tessera::client {

std::array<double, 3> cie1931(double wavelength_nm) {
  using tables::kCieMatching;
  if (!(wavelength_nm >= tables::kCieFirstNm && wavelength_nm <= tables::kCieLastNm)) return {0, 0, 0};
  const double position = (wavelength_nm - tables::kCieFirstNm) / tables::kCieStepNm;
  const int index = std::min(static_cast<int>(position), tables::kCieCount - 2);
  const tables::CieRow &low = kCieMatching[static_cast<std::size_t>(index)],
                       &high = kCieMatching[static_cast<std::size_t>(index) + 1];
  const double t = position - index;
  return {(1 - t) * low.x + t * high.x, (1 - t) * low.y + t * high.y, (1 - t) * low.z + t * high.z};
}

}  // namespace tessera::client
