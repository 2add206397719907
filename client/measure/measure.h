// Measures a scene: meters in, figures out.
#pragma once

#include "absl/status/statusor.h"
#include "measure/measured.h"
#include "measure/plan.h"
#include "measure/sampling.h"

namespace tessera::client {

/// Samples what is planned, and adds it up. `algorithm`: the integrator by which it is rendered.
absl::StatusOr<Measured> measure(const MeasurePlan& plan, const MeasuredScene& scene, const MeterFile& file,
                                 const std::string& algorithm, const SamplingOptions& options,
                                 const RenderProbes& render, bool& stopped);

}  // namespace tessera::client
