// Cameras that see all around: where the places of their films look.
#pragma once

#include "absl/status/status.h"
#include "render/sensor/sensor_record.h"
#include "tessera/v1/camera.pb.h"

namespace tessera::render {

/// Sets the kind, the places and the table of a camera that has a cylinder, a sphere, a panorama or a cube
/// map; the record has the film's size. InvalidArgument where the film or a field cannot be that.
absl::Status set_all_around(const v1::Camera& camera, SensorRecord& record);

}  // namespace tessera::render
