// Cameras of probes, for the kernels.
#pragma once

#include "absl/status/status.h"
#include "render/film/sample_source.h"
#include "render/scene/blob_source.h"
#include "render/scene/placement/render_space.h"
#include "render/sensor/sensor_record.h"
#include "tessera/v1/scene.pb.h"
#include "wire/algorithm.h"

namespace tessera::render {

/// Fills the record of a camera of probes, whose film has `width` x `height` pixels. Without `blobs`, meshes
/// are not looked into. InvalidArgument names the probe that is at fault, also where `algorithm` does not
/// read probes, or not ones of its kind.
absl::Status set_probes(const v1::Camera& camera, const RenderSpace& space,
                        const wire::AlgorithmTraits& algorithm, const BlobSource* blobs,
                        SensorRecord& record);

/// InvalidArgument where samples of a pixel would reach its neighbours, or be spread over light that several
/// pixels share.
absl::Status check_probe_film(const v1::PixelFilter& filter, const v1::JobSpec& job);

}  // namespace tessera::render
