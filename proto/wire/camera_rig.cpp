#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "wire/scene_views.h"

namespace tessera::wire {

namespace {

/// Views of a grid: as many as anyone can look at.
constexpr std::uint64_t kMostCameras = 4096;

absl::Status fault(const std::string& message) {
  return absl::InvalidArgumentError(absl::StrCat("rig: ", message));
}

std::vector<v1::Camera> stereo_pair(const v1::CameraRig::StereoPair& pair, const v1::Camera& middle) {
  std::vector<v1::Camera> cameras(2, middle);
  for (std::size_t eye = 0; eye < 2; ++eye) {
    cameras[eye].set_view_name(eye == 0 ? "left" : "right");
    v1::Viewpoint& viewpoint = *cameras[eye].mutable_viewpoint();
    viewpoint.set_x((eye == 0 ? -0.5 : 0.5) * pair.interocular_distance());
    viewpoint.set_axes(pair.axes());
    viewpoint.set_convergence_distance(pair.convergence_distance());
    viewpoint.set_pole_merge_from_degrees(pair.pole_merge_from_degrees());
    viewpoint.set_pole_merge_to_degrees(pair.pole_merge_to_degrees());
  }
  return cameras;
}

absl::StatusOr<std::vector<v1::Camera>> grid_of(const v1::CameraRig::Grid& grid, const v1::Camera& middle) {
  const std::uint64_t count = std::uint64_t{grid.columns()} * grid.rows();
  if (count == 0 || count > kMostCameras) {
    return fault(
        absl::StrCat("a grid has 1 to ", kMostCameras, " cameras, not ", grid.columns(), " x ", grid.rows()));
  }
  std::vector<v1::Camera> cameras;
  for (std::uint32_t row = 0; row < grid.rows(); ++row) {
    for (std::uint32_t column = 0; column < grid.columns(); ++column) {
      v1::Viewpoint& viewpoint = *cameras.emplace_back(middle).mutable_viewpoint();
      viewpoint.set_x((column - 0.5 * (grid.columns() - 1)) * grid.spacing_x());
      viewpoint.set_y((0.5 * (grid.rows() - 1) - row) * grid.spacing_y());
      viewpoint.set_axes(grid.axes());
      viewpoint.set_convergence_distance(grid.convergence_distance());
    }
  }
  return cameras;
}

/// Multiplies a matrix of 16 elements, or none for the identity, from the right.
void multiply(v1::Matrix& left, const v1::Matrix& right) {
  if (right.elements().empty()) return;
  if (left.elements().empty()) {
    left = right;
    return;
  }
  const v1::Matrix a = left;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      double sum = 0;
      for (int i = 0; i < 4; ++i) sum += a.elements(4 * row + i) * right.elements(4 * i + column);
      left.set_elements(4 * row + column, sum);
    }
  }
}

absl::StatusOr<std::vector<v1::Camera>> list_of(const v1::CameraRig::Places& list, const v1::Camera& origin) {
  if (list.places().empty()) return fault("its list has no cameras");
  const auto is_matrix = [](const v1::Matrix& matrix) {
    return matrix.elements().empty() || matrix.elements_size() == 16;
  };
  if (!is_matrix(origin.world_from_camera()) || !is_matrix(origin.world_from_camera_end()))
    return fault("a matrix of its camera has not 16 elements");
  std::vector<v1::Camera> cameras;
  for (const v1::CameraRig::Place& place : list.places()) {
    if (!is_matrix(place.camera_from_view())) {
      return fault(
          absl::StrCat("a matrix has ", place.camera_from_view().elements_size(), " elements instead of 16"));
    }
    v1::Camera& camera = cameras.emplace_back(origin);
    camera.set_view_name(place.name());
    multiply(*camera.mutable_world_from_camera(), place.camera_from_view());
    if (camera.has_world_from_camera_end())
      multiply(*camera.mutable_world_from_camera_end(), place.camera_from_view());
  }
  return cameras;
}

absl::StatusOr<std::vector<v1::Camera>> cameras_of(const v1::CameraRig& rig, const v1::Camera& camera) {
  if (rig.kind_case() == v1::CameraRig::kList) return list_of(rig.list(), camera);
  if (camera.has_viewpoint()) return fault("its camera has a viewpoint of its own");
  if (rig.kind_case() == v1::CameraRig::kStereo) return stereo_pair(rig.stereo(), camera);
  if (rig.kind_case() == v1::CameraRig::kGrid) return grid_of(rig.grid(), camera);
  return fault("it has no kind, or one that is unknown");
}

}  // namespace

absl::Status resolve_rig(v1::Scene& scene) {
  if (!scene.has_rig()) return absl::OkStatus();
  if (scene.views_size() > 0) return fault("a scene with a rig has no views beside");
  auto cameras = cameras_of(scene.rig(), scene.camera());
  if (!cameras.ok()) return cameras.status();
  // All views measure from where the camera was.
  if (!scene.has_render_origin()) *scene.mutable_render_origin() = camera_place(scene);
  *scene.mutable_camera() = std::move(cameras->front());
  for (auto camera = cameras->begin() + 1; camera != cameras->end(); ++camera)
    *scene.add_views() = std::move(*camera);
  scene.clear_rig();
  return absl::OkStatus();
}

}  // namespace tessera::wire
