// Settings of single integrators, as the kernels read them: messages of settings.proto, resolved, without
// choices.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tessera::render {

/// The message of RenderSettings with the integrator's name, as numbers by the names of its fields: for
/// settings that need no struct. Values of enums are their numbers, on is 1.
struct OwnSettings {
  struct Value {
    std::string name;
    double number;
  };
  std::vector<Value> values;

  /// 0 where there is no such field.
  double operator[](std::string_view name) const {
    for (const Value& value : values) {
      if (value.name == name) return value.number;
    }
    return 0;
  }
};

/// RenderSettings.photon
struct PhotonSettings {
  float radius = 0;          // radius in the first pass, render-space units; 0: as the pixels' footprint says
  float caustic_radius = 0;  // radius for caustics; 0: that of `radius`
  std::uint32_t photons = 0;  // light paths of a pass; 0: as the film's pixels say
  bool one_map = false;       // the classic algorithm: all passes read the map of the first
  bool direct = false;        // direct light is found by photons, too, not by sampling the lights
};

/// RenderSettings.mlt
struct MetropolisSettings {
  std::uint32_t mutations = 1;   // mutations of a chain
  std::uint32_t candidates = 1;  // candidates for the path that a chain begins at
  float large_steps = 0.3f;      // probability
  float step = 1.0f / 32;        // largest change of a number by a small step
};

/// RenderSettings.radiosity
struct RadiositySettings {
  double error_bound = 0.01;  // largest error of a link's light, over the mean irradiance of what is lit
  double smallest_area = 0;   // scene units squared; patches below it are not split
  double residual = 1e-4;     // power that the last sweep of the solution moved, over all of it
  bool final_gather = false;  // patches are seen by one bounce, and not shown themselves
  std::uint64_t memory_limit = std::uint64_t{4} << 30;  // bytes of patches and links
};

/// RenderSettings.irradiance_cache
struct IrradianceCacheSettings {
  float error = 0.3f;
  std::int32_t samples = 1024;
  float least_reach = 3, most_reach = 32;  // widths of a pixel
  bool view = false;
  std::int32_t glossy_bands = 8;  // bands of spherical harmonics; 0: no records at glossy surfaces
};

}  // namespace tessera::render
