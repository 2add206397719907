// The camera of a scene, for the kernels.
#pragma once

#include "absl/status/statusor.h"
#include "render/film/sample_source.h"
#include "render/scene/blob_source.h"
#include "render/scene/placement/render_space.h"
#include "render/scene/view/lens.h"
#include "render/sensor/sensor_record.h"
#include "tessera/v1/scene.pb.h"
#include "wire/algorithm.h"

namespace tessera::render {

/// The medium that the camera stands in is left to the caller. InvalidArgument names what is at fault, also
/// where `algorithm` cannot work with the camera or the film. `spectral`: for jobs of wavelengths. Cameras
/// with a distortion map need `surroundings.blobs`.
absl::StatusOr<SensorRecord> build_sensor(const v1::Camera& camera, FilmSize film, const RenderSpace& space,
                                          const wire::AlgorithmTraits& algorithm, bool spectral = false,
                                          const LensSurroundings& surroundings = {});

}  // namespace tessera::render
