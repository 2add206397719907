#include "import/tessera_scene/animation.h"

#include <ImathMatrix.h>
#include <ImathVec.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "import/geometry/motion_keys.h"
#include "import/input/concat.h"

namespace tessera::client {
namespace {

using Imath::M44d;
using Imath::V3d;

absl::Status fault(int track, const std::string& what) {
  return absl::InvalidArgumentError(concat("animation: track ", track, ": ", what));
}

/// For a sound track.
std::vector<TimedPlacing> keys_of(const v1::Track& track) {
  std::vector<TimedPlacing> keys;
  for (const v1::Track::Key& key : track.keys())
    keys.push_back({key.frame(), matrix_of(key.world_from_target())});
  return keys;
}

/// Part of the time for which the shutter is open that lies before the frame.
double part_before(v1::Animation::ShutterPosition position) {
  switch (position) {
    case v1::Animation::CENTER:
      return 0.5;
    case v1::Animation::END:
      return 1;
    default:
      return 0;
  }
}

}  // namespace

absl::Status check_track(const v1::Scene& scene, int number) {
  const v1::Track& track = scene.animation().tracks(number);
  if (track.target_case() == v1::Track::TARGET_NOT_SET || (track.has_camera() && !track.camera()))
    return fault(number, "it moves neither the camera nor an instance");
  if (track.has_instance() && track.instance() >= static_cast<std::uint32_t>(scene.instances_size()))
    return fault(number, concat("there is no instance ", track.instance()));
  if (track.keys().empty()) return fault(number, "it has no keys");
  double before = -HUGE_VAL;
  for (const v1::Track::Key& key : track.keys()) {
    if (!std::isfinite(key.frame()) || key.frame() <= before)
      return fault(number, "frames of keys have to ascend");
    before = key.frame();
    const int size = key.world_from_target().elements_size();
    if ((size != 0 && size != 16) || !is_decomposable(matrix_of(key.world_from_target())))
      return fault(number, concat("the matrix at frame ", key.frame(), " is singular or no matrix"));
  }
  return absl::OkStatus();
}

absl::Status check_animation(const v1::Scene& scene) {
  const v1::Animation& animation = scene.animation();
  if (!(animation.frames_per_second() >= 0 && animation.frames_per_second() <= 1e6))
    return absl::InvalidArgumentError("animation: frames_per_second is not within 0 and 1000000");
  if (!(animation.shutter() >= 0 && animation.shutter() <= 1))
    return absl::InvalidArgumentError("animation: the shutter is open for 0 to 1 of a frame");
  if (!v1::Animation::ShutterPosition_IsValid(animation.shutter_position()))
    return absl::InvalidArgumentError("animation: shutter_position is unknown");
  for (int i = 0; i < animation.tracks_size(); ++i) {
    if (absl::Status status = check_track(scene, i); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status pose_at_frame(double frame, v1::Scene& scene) {
  if (!scene.has_animation()) return absl::OkStatus();
  if (absl::Status status = check_animation(scene); !status.ok()) return status;
  const v1::Animation animation = std::move(*scene.mutable_animation());
  scene.clear_animation();
  const bool only_camera = std::ranges::all_of(animation.tracks(), &v1::Track::has_camera);
  const double open = frame - part_before(animation.shutter_position()) * animation.shutter();
  for (const v1::Track& track : animation.tracks()) {
    const std::vector<TimedPlacing> placings =
        during_shutter(keys_of(track), open, open + animation.shutter());
    if (track.has_camera()) {
      write_all_elements(placings[0].place, *scene.mutable_camera()->mutable_world_from_camera());
      write_motion(placings, &v1::Camera::mutable_world_from_camera_end, *scene.mutable_camera());
      if (only_camera && !scene.has_render_origin()) {
        const M44d first = matrix_of(track.keys(0).world_from_target());
        scene.mutable_render_origin()->set_x(first[3][0]);
        scene.mutable_render_origin()->set_y(first[3][1]);
        scene.mutable_render_origin()->set_z(first[3][2]);
      }
    } else {
      v1::Instance& instance = *scene.mutable_instances(static_cast<int>(track.instance()));
      write_all_elements(placings[0].place, *instance.mutable_world_from_instance());
      write_motion(placings, &v1::Instance::mutable_world_from_instance_end, instance);
    }
  }
  return absl::OkStatus();
}

}  // namespace tessera::client
