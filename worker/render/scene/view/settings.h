// A job's settings as the builders take them.
#pragma once

#include <cstdint>
#include <optional>

#include "render/accel/structure/scene_structure.h"
#include "render/integrator/scene_tables.h"
#include "tessera/v1/job.pb.h"
#include "wire/algorithm.h"

namespace tessera::render {

struct Settings {
  v1::Algorithms asked;  // read by builders: what one of them alone needs is no member here
  const wire::AlgorithmTraits* algorithm = nullptr;
  SamplerConfig sampler;
  std::int32_t max_depth = 5;  // scattering events on a path
  AovRequest aovs;
  OwnSettings own;  // the algorithm's
  IrradianceCacheSettings irradiance_cache;
  RadiositySettings radiosity;
  bool ignore_non_diffuse = false;
  std::optional<StructureKind> structure;               // none: Embree's
  TexelFilter texture_filter = TexelFilter::kBilinear;  // used for images that name none
  bool straight_shadows = false;                        // light passes clear glass unbent
  bool light_into_lens = false;                         // ghosts of lights are found from the lights, too
  bool spectral = false;                                // paths carry light of wavelengths
  PhotonSettings photon;
  MetropolisSettings metropolis;
};

/// The settings of a job that has been checked (wire/job_check.h).
Settings read_settings(const v1::JobSpec& job);

}  // namespace tessera::render
