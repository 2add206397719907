// Viewpoints beside a camera's own place (Camera.viewpoint).
#pragma once

#include "tessera/v1/camera.pb.h"

namespace tessera::wire {

/// From the space of the camera's viewpoint to that of the camera; empty where they are the same. The eyes of
/// panoramas go around on circles, so that theirs has the height alone.
v1::Matrix camera_from_viewpoint(const v1::Camera& camera);

/// How far the screen window moves on the plane z = 1, so that the window that the camera sees at the
/// convergence distance is the viewpoint's, too.
struct WindowShift {
  double x = 0, y = 0;
};
WindowShift window_shift(const v1::Camera& camera);

}  // namespace tessera::wire
