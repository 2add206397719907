// Measures a scene: meters in, figures out.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "measure/annual.h"
#include "measure/eye.h"
#include "measure/measured.h"
#include "measure/plan.h"
#include "measure/sampling.h"

namespace tessera::client {

/// How a scene is rendered that is measured.
struct MeasureRenderers {
  RenderProbes probes;
  RenderPicture picture;
  RenderUnderPatch under_patch;  // afterwards the scene has no light of its own: called last
};

struct MeasureRun {
  Measured measured;
  bool stopped = false;  // the time was up
};

/// Samples what is planned, and adds it up. `algorithm`: the integrator by which it is rendered
/// but where others are chosen (SamplingOptions::integrators). Errors are
/// those of the renderers, and InvalidArgument with what is wrong with meters that are read of pictures or of
/// a year.
absl::StatusOr<MeasureRun> measure(const MeasurePlan& plan, const MeasuredScene& scene, const MeterFile& file,
                                   const std::string& algorithm, const SamplingOptions& options,
                                   const MeasureRenderers& renderers);

}  // namespace tessera::client
