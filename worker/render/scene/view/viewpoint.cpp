#include "render/scene/view/viewpoint.h"

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "wire/viewpoint.h"

namespace tessera::render {

absl::StatusOr<Transform> camera_from_viewpoint(const v1::Camera& camera) {
  const v1::Viewpoint& viewpoint = camera.viewpoint();
  std::vector<std::string> faults;
  if (!(viewpoint.convergence_distance() >= 0)) {
    faults.push_back(absl::StrCat("a viewpoint's convergence distance is above 0, or 0 for infinity, not ",
                                  viewpoint.convergence_distance()));
  }
  const double from = viewpoint.pole_merge_from_degrees(), to = viewpoint.pole_merge_to_degrees();
  if (from != 0 || to != 0) {
    if (!camera.has_panorama()) faults.emplace_back("only panoramas merge their viewpoints at the poles");
    if (!(from >= 0 && from < to && to <= 90)) {
      faults.push_back(absl::StrCat("viewpoints merge between two latitudes from 0 to 90 degrees, not from ",
                                    from, " to ", to));
    }
  }
  if (faults.empty()) return Transform::from_proto(wire::camera_from_viewpoint(camera));
  return absl::InvalidArgumentError(absl::StrCat("camera: ", absl::StrJoin(faults, "; ")));
}

void move_window(const v1::Camera& camera, SensorRecord& record) {
  const wire::WindowShift shift = wire::window_shift(camera);
  record.offset_x += static_cast<float>(shift.x);
  record.offset_y += static_cast<float>(shift.y);
}

}  // namespace tessera::render
