// Distortion of films, as tables for the kernels.
#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "render/scene/blob_source.h"
#include "render/sensor/distortion_table.h"
#include "render/sensor/sensor_record.h"
#include "tessera/v1/camera.pb.h"

namespace tessera::render {

/// The table of a camera that has a distortion, for the film that the record has. Places beyond the film are
/// in it for 8 pixels, which filters may look at, and black farther out. InvalidArgument names what is wrong
/// with the distortion: for one that folds, the pixel next to the middle where it does.
absl::StatusOr<std::shared_ptr<const DistortionTable>> distortion_table(const v1::Camera& camera,
                                                                        const SensorRecord& sensor,
                                                                        const BlobSource& blobs);

}  // namespace tessera::render
