// Settings that only some algorithms have (wire/own_settings.h), as the command line gives them; absent or
// UNSPECIFIED: as the scene has it, or the default.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "tessera/v1/settings.pb.h"

namespace tessera::client {

/// v1::PhotonSettings
struct PhotonWishes {
  std::optional<double> radius;          // scene units
  std::optional<double> caustic_radius;  // the same of caustics
  std::optional<std::uint32_t> photons;  // light paths of a pass
  v1::PhotonMap map{};
  v1::PhotonLight light{};
};

/// v1::MetropolisSettings
struct MetropolisWishes {
  std::optional<std::uint32_t> mutations, candidates;
  std::optional<double> large_steps, step;
};

/// v1::RadiositySettings
struct RadiosityWishes {
  std::optional<double> error_bound, smallest_area, residual;
  std::optional<bool> final_gather;
  bool ignore_non_diffuse = false;
  std::optional<std::uint64_t> memory_limit;  // bytes
};

/// v1::IrradianceCache
struct CacheWishes {
  std::optional<double> error;
  std::optional<std::uint32_t> samples;
  std::optional<std::pair<double, double>> reach;  // least and most
  std::optional<std::uint32_t> glossy_bands;
  bool view = false;
};

/// v1::PreviewSettings
struct PreviewWishes {
  v1::Shadows shadows{};
  std::optional<double> ambient;
};

struct OwnWishes {
  PhotonWishes photon;
  MetropolisWishes metropolis;
  RadiosityWishes radiosity;
  CacheWishes cache;
  PreviewWishes preview;
  std::optional<double> occlusion_distance;  // v1::AmbientOcclusion
  std::optional<double> guiding_samples;     // v1::GuidingSettings

  /// With the settings of those algorithms alone for which something is asked.
  v1::RenderSettings message() const;
};

}  // namespace tessera::client
