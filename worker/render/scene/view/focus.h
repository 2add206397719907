// Cameras that are focused on what a place of the picture shows.
#pragma once

#include "absl/status/status.h"
#include "render/accel/ray_query.h"
#include "render/integrator/scene_tables.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

/// Sets the distance of the camera's lens to that of what is first hit at Camera.focus_point when the shutter
/// opens, borders of media apart. `sensor` is the camera's, focused anywhere. A lens system shows another
/// place of the scene as its focus moves, so that the distance is found by steps. InvalidArgument where
/// nothing is hit.
absl::Status focus_on_point(const SensorRecord& sensor, const SceneArrays& arrays, const RayQuery& rays,
                            v1::Camera& camera);

}  // namespace tessera::render
