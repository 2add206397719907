#include "render/integrator/irradiance_cache/record_site.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace tessera::render::TESSERA_ISA {

bool are_usual(const float* numbers, std::size_t count) {
  return std::all_of(numbers, numbers + count,
                     [](float x) { return std::isfinite(x) && std::abs(x) < 1e18f; });
}

bool is_sound(const RecordSite& site) {
  const float* const n = site.n;
  return std::abs(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1) < 1e-3f && site.radius > 0 && site.pixel >= 0;
}

}  // namespace tessera::render::TESSERA_ISA
