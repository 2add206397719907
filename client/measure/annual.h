// Daylight of a year at points of a scene, by daylight coefficients: what each patch of the sky gives them.
#pragma once

#include <ImathVec.h>

#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "import/input/imported_scene.h"
#include "measure/measured.h"
#include "measure/sampling.h"
#include "tessera/v1/meter.pb.h"

namespace tessera::client {

/// Renders probes in a scene that one patch of the sky lights, and nothing else: with a radiance of 1 by the
/// map `sky`, a PFM picture of all directions, which `light` places.
using RenderUnderPatch =
    std::function<absl::StatusOr<ProbePicture>(const ProbeJob& job, const v1::Light& light, std::string sky)>;

struct AnnualSampling {
  std::uint64_t samples = 256;  // of each point and patch
  std::uint64_t seed = 0;
  std::function<void(std::size_t patch, std::size_t patches)> progress = {};
};

/// Measures a year: meters of several metrics, with names that begin with the meter's. `folder`: that weather
/// files are relative to. InvalidArgument with what is wrong with the meter or its weather file.
absl::StatusOr<std::vector<MeasuredMeter>> measure_year(const v1::AnnualDaylightMeter& meter,
                                                        const std::string& name, const std::string& folder,
                                                        const ImportedScene& scene, bool y_up,
                                                        const AnnualSampling& sampling,
                                                        const RenderUnderPatch& render);

}  // namespace tessera::client
