// Viewpoints beside a camera's own place.
#pragma once

#include "absl/status/statusor.h"
#include "render/scene/placement/transform.h"
#include "render/sensor/sensor_record.h"
#include "tessera/v1/camera.pb.h"

namespace tessera::render {

/// wire::camera_from_viewpoint(); InvalidArgument with all that is wrong with the camera's viewpoint.
absl::StatusOr<Transform> camera_from_viewpoint(const v1::Camera& camera);

/// Moves the window of a film whose places are set, where the viewpoint's axes want that.
void move_window(const v1::Camera& camera, SensorRecord& record);

}  // namespace tessera::render
