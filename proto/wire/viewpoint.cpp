#include "wire/viewpoint.h"

#include <cmath>

namespace tessera::wire {

namespace {

bool converges(const v1::Viewpoint& viewpoint) {
  return viewpoint.axes() != v1::Viewpoint::PARALLEL && viewpoint.convergence_distance() > 0;
}

bool moves_window(const v1::Camera& camera) {
  return converges(camera.viewpoint()) && camera.viewpoint().axes() == v1::Viewpoint::OFF_AXIS &&
         (camera.has_perspective() || camera.has_lens());
}

}  // namespace

v1::Matrix camera_from_viewpoint(const v1::Camera& camera) {
  v1::Matrix matrix;
  if (!camera.has_viewpoint()) return matrix;
  const v1::Viewpoint& viewpoint = camera.viewpoint();
  const double across = camera.has_panorama() ? 0 : viewpoint.x();
  double x[3] = {1, 0, 0}, y[3] = {0, 1, 0}, z[3] = {0, 0, 1};
  if (converges(viewpoint) && !moves_window(camera) && !camera.has_panorama()) {
    // z goes to the point on the axis, and x stays level.
    const double distance = viewpoint.convergence_distance();
    const double length = std::hypot(viewpoint.x(), viewpoint.y(), distance),
                 level = std::hypot(viewpoint.x(), distance);
    z[0] = -viewpoint.x() / length, z[1] = -viewpoint.y() / length, z[2] = distance / length;
    x[0] = distance / level, x[2] = viewpoint.x() / level;
    y[0] = z[1] * x[2], y[1] = z[2] * x[0] - z[0] * x[2], y[2] = -z[1] * x[0];
  }
  const double place[3] = {across, viewpoint.y(), 0};
  for (int row = 0; row < 3; ++row)
    for (const double element : {x[row], y[row], z[row], place[row]}) matrix.add_elements(element);
  for (const double element : {0, 0, 0, 1}) matrix.add_elements(element);
  return matrix;
}

WindowShift window_shift(const v1::Camera& camera) {
  if (!moves_window(camera)) return {};
  const v1::Viewpoint& viewpoint = camera.viewpoint();
  return {-viewpoint.x() / viewpoint.convergence_distance(),
          -viewpoint.y() / viewpoint.convergence_distance()};
}

}  // namespace tessera::wire
