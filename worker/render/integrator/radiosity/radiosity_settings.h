// How radiosity is computed: RadiositySettings of settings.proto, resolved.
#pragma once

#include <cstdint>

namespace tessera::render {

struct RadiositySettings {
  double error_bound = 0.01;  // of a link's light, over the mean irradiance of what is lit
  double smallest_area = 0;   // scene units squared; patches below it are not split
  double residual = 1e-4;     // of the solution: power that the last sweep moved, over all of it
  bool final_gather = false;  // patches are seen by one bounce, and not shown themselves
  std::uint64_t memory_limit = std::uint64_t{4} << 30;  // bytes of patches and links
};

}  // namespace tessera::render
