#include "import/tessera_scene/animation.h"

#include <ImathMatrix.h>
#include <ImathMatrixAlgo.h>
#include <ImathQuat.h>
#include <ImathVec.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "import/geometry/transform.h"
#include "import/input/concat.h"

namespace tessera::client {
namespace {

using Imath::M33d;
using Imath::M44d;
using Imath::Quatd;
using Imath::V3d;

/// A matrix that acts on row vectors: a stretch, then a rotation, then a translation.
struct Pose {
  M33d stretch;
  Quatd rotation;
  V3d translation;
};

M33d mean(const M33d& a, const M33d& b) {
  M33d result;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) result[i][k] = 0.5 * (a[i][k] + b[i][k]);
  }
  return result;
}

/// Polar decomposition: the rotation is the limit of averaging a matrix with its inverse's transpose.
std::optional<Pose> decomposed(const M44d& matrix) {
  const double determinant = determinant3(matrix);
  if (!is_finite(matrix) || determinant == 0 || !std::isfinite(determinant)) return std::nullopt;
  M33d linear;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) linear[i][k] = matrix[i][k];
  }
  M33d rotation = linear;
  for (int i = 0; i < 60; ++i) {
    const M33d next = mean(rotation, rotation.inverse().transposed());
    const bool settled = next.equalWithAbsError(rotation, 1e-15);
    rotation = next;
    if (settled) break;
  }
  // Mirrors are part of the stretch.
  if (determinant < 0) rotation *= -1;
  M44d turn;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) turn[i][k] = rotation[i][k];
  }
  return Pose{
      linear * rotation.transposed(), Imath::extractQuat(turn), {matrix[3][0], matrix[3][1], matrix[3][2]}};
}

M44d composed(const Pose& pose) {
  const M33d linear = pose.stretch * pose.rotation.toMatrix33();
  M44d matrix;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) matrix[i][k] = linear[i][k];
    matrix[3][i] = pose.translation[i];
  }
  return matrix;
}

M44d matrix_of(const v1::Matrix& message) {
  M44d columns;
  if (message.elements_size() == 16) std::copy_n(message.elements().begin(), 16, columns.getValue());
  return columns.transposed();
}

absl::Status fault(int track, const std::string& what) {
  return absl::InvalidArgumentError(concat("animation: track ", track, ": ", what));
}

/// For a sound track.
M44d matrix_at(const v1::Track& track, double frame) {
  const auto after =
      std::ranges::find_if(track.keys(), [&](const auto& key) { return key.frame() >= frame; });
  if (after == track.keys().begin()) return matrix_of(after->world_from_target());
  const auto before = after - 1;
  if (after == track.keys().end() || after->frame() == frame)
    return matrix_of((after == track.keys().end() ? before : after)->world_from_target());
  const Pose a = *decomposed(matrix_of(before->world_from_target())),
             b = *decomposed(matrix_of(after->world_from_target()));
  const double t = (frame - before->frame()) / (after->frame() - before->frame());
  Pose between{M33d(), Imath::slerpShortestArc(a.rotation, b.rotation, t),
               a.translation * (1 - t) + b.translation * t};
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) between.stretch[i][k] = (1 - t) * a.stretch[i][k] + t * b.stretch[i][k];
  }
  return composed(between);
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
    if ((size != 0 && size != 16) || !decomposed(matrix_of(key.world_from_target())))
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
  for (const v1::Track& track : animation.tracks()) {
    const M44d start = matrix_at(track, frame), end = matrix_at(track, frame + animation.shutter());
    const bool moves = animation.shutter() > 0 && !(start == end);
    if (track.has_camera()) {
      write_all_elements(start, *scene.mutable_camera()->mutable_world_from_camera());
      if (moves) write_all_elements(end, *scene.mutable_camera()->mutable_world_from_camera_end());
      if (only_camera && !scene.has_render_origin()) {
        const M44d first = matrix_of(track.keys(0).world_from_target());
        scene.mutable_render_origin()->set_x(first[3][0]);
        scene.mutable_render_origin()->set_y(first[3][1]);
        scene.mutable_render_origin()->set_z(first[3][2]);
      }
    } else {
      v1::Instance& instance = *scene.mutable_instances(static_cast<int>(track.instance()));
      write_all_elements(start, *instance.mutable_world_from_instance());
      if (moves) write_all_elements(end, *instance.mutable_world_from_instance_end());
    }
  }
  return absl::OkStatus();
}

}  // namespace tessera::client
