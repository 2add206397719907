// Settings of photon mapping (tessera.v1.PhotonSettings), as the kernels read them.
#pragma once

#include <cstdint>

namespace tessera::render {

struct PhotonConfig {
  float radius = 0;           // of the first pass, render-space units; 0: as the pixels' footprint says
  float caustic_radius = 0;   // the same for caustics; 0: as `radius` says
  std::uint32_t photons = 0;  // light paths of a pass; 0: as the film's pixels say
  bool one_map = false;       // the classic algorithm: all passes read the map of the first
  bool direct = false;        // direct light is found by photons, too, not by sampling the lights
};

}  // namespace tessera::render
