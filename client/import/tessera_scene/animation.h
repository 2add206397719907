// A scene at one frame of its animation.
#pragma once

#include "absl/status/status.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::client {

/// Puts what Scene.animation moves where it is at `frame`, and takes the animation away. Turns are
/// interpolated as rotations, stretches (what is left of a matrix without its rotation [Shoemake1992])
/// and translations linearly. Where only the camera moves, coordinates are measured from its first key, so
/// that workers can keep what they have built. InvalidArgument for tracks without a target that exists, whose
/// frames do not ascend, or whose matrices are singular or not finite.
absl::Status pose_at_frame(double frame, v1::Scene& scene);

/// The same checks, without a pose: of the whole animation, and of one of its tracks.
absl::Status check_animation(const v1::Scene& scene);
absl::Status check_track(const v1::Scene& scene, int number);

}  // namespace tessera::client
