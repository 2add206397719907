#include "render/scene/view/all_around.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "render/sensor/panorama_table.h"

namespace tessera::render {

namespace {

constexpr double kRadians = std::numbers::pi / 180;

absl::Status set_cylinder(const v1::CylindricalCamera& cylinder, SensorRecord& record) {
  const double fov = cylinder.fov_degrees();
  if (!(fov > 0 && fov <= 360)) {
    return absl::InvalidArgumentError(
        absl::StrCat("camera: a field of view of ", fov, " degrees is not in (0, 360]"));
  }
  record.kind = SensorKind::kCylindrical;
  const double width = fov * kRadians, pixel = width / record.width;
  record.scale_x = static_cast<float>(pixel), record.offset_x = static_cast<float>(-width / 2);
  record.scale_y = static_cast<float>(-pixel),
  record.offset_y = static_cast<float>(pixel * record.height / 2);
  return absl::OkStatus();
}

SensorKind kind_of(v1::SphericalCamera::Mapping mapping) {
  switch (mapping) {
    case v1::SphericalCamera::EQUAL_AREA_OCTAHEDRAL:
      return SensorKind::kOctahedral;
    case v1::SphericalCamera::EQUAL_AREA_CYLINDRICAL:
      return SensorKind::kEqualAreaCylindrical;
    default:
      return SensorKind::kEquirectangular;
  }
}

void set_sphere(const v1::SphericalCamera& sphere, SensorRecord& record) {
  record.kind = kind_of(sphere.mapping());
  record.scale_x = 1.0f / static_cast<float>(record.width);
  record.scale_y = 1.0f / static_cast<float>(record.height);
}

absl::Status set_panorama(const v1::Camera& camera, SensorRecord& record) {
  const v1::PanoramaCamera& panorama = camera.panorama();
  const double left = panorama.has_longitude_min_degrees() ? panorama.longitude_min_degrees() : -180,
               right = panorama.has_longitude_max_degrees() ? panorama.longitude_max_degrees() : 180,
               low = panorama.has_latitude_min_degrees() ? panorama.latitude_min_degrees() : -90,
               high = panorama.has_latitude_max_degrees() ? panorama.latitude_max_degrees() : 90;
  if (!(left >= -360 && right <= 360 && left < right && right - left <= 360 && low >= -90 && low < high &&
        high <= 90)) {
    return absl::InvalidArgumentError(
        absl::StrCat("camera: a panorama goes to the right by 360 degrees at most, and up within -90 to 90: "
                     "not from ",
                     left, " to ", right, " and from ", low, " to ", high));
  }
  record.kind = SensorKind::kPanorama;
  record.scale_x = static_cast<float>((right - left) * kRadians / record.width);
  record.offset_x = static_cast<float>(left * kRadians);
  record.scale_y = static_cast<float>((low - high) * kRadians / record.height);
  record.offset_y = static_cast<float>(high * kRadians);
  auto table = std::make_shared<PanoramaTable>();
  const v1::Viewpoint& viewpoint = camera.viewpoint();
  table->eyes.radius = static_cast<float>(viewpoint.x());
  if (viewpoint.axes() != v1::Viewpoint::PARALLEL && viewpoint.convergence_distance() > 0)
    table->eyes.inverse_convergence = static_cast<float>(1 / viewpoint.convergence_distance());
  if (viewpoint.pole_merge_to_degrees() > 0) {
    table->eyes.merge_from = static_cast<float>(viewpoint.pole_merge_from_degrees() * kRadians);
    table->eyes.merge_to = static_cast<float>(viewpoint.pole_merge_to_degrees() * kRadians);
  }
  record.panorama = std::move(table);
  return absl::OkStatus();
}

// In the order +x, -x, +y, -y, +z, -z.
enum Face : std::int8_t { kRight, kLeft, kUp, kDown, kFront, kBack };
constexpr std::array<CubeFace, 6> kFaces = {{
    {0, 0, {0, 0, -1}, {0, 1, 0}, {1, 0, 0}},
    {0, 0, {0, 0, 1}, {0, 1, 0}, {-1, 0, 0}},
    {0, 0, {1, 0, 0}, {0, 0, -1}, {0, 1, 0}},
    {0, 0, {1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
    {0, 0, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
    {0, 0, {-1, 0, 0}, {0, 1, 0}, {0, 0, -1}},
}};

CubeRecord cube_of(const v1::CubeMapCamera& map) {
  CubeRecord cube;
  cube.equiangular = map.equiangular();
  cube.faces = 0;
  const auto add = [&](Face face, float column, float row) {
    CubeFace& added = cube.face[cube.faces++];
    added = kFaces[static_cast<std::size_t>(face)];
    added.column = column, added.row = row;
  };
  switch (map.layout()) {
    case v1::CubeMapCamera::VERTICAL_CROSS:
      cube.columns = 3, cube.rows = 4;
      add(kUp, 1, 0), add(kLeft, 0, 1), add(kFront, 1, 1), add(kRight, 2, 1), add(kDown, 1, 2);
      add(kBack, 1, 3);
      // It goes on where the lower face ends.
      for (float& x : cube.face[5].right) x = -x;
      for (float& x : cube.face[5].up) x = -x;
      break;
    case v1::CubeMapCamera::STRIP:
      cube.columns = 6;
      for (int i = 0; i < 6; ++i) add(static_cast<Face>(i), static_cast<float>(i), 0);
      break;
    case v1::CubeMapCamera::COLUMN:
      cube.rows = 6;
      for (int i = 0; i < 6; ++i) add(static_cast<Face>(i), 0, static_cast<float>(i));
      break;
    case v1::CubeMapCamera::FRONT:
      add(kFront, 0, 0);
      break;
    default:
      cube.columns = 4, cube.rows = 3;
      add(kUp, 1, 0), add(kLeft, 0, 1), add(kFront, 1, 1), add(kRight, 2, 1), add(kBack, 3, 1);
      add(kDown, 1, 2);
      break;
  }
  return cube;
}

absl::Status set_cube_map(const v1::CubeMapCamera& map, SensorRecord& record) {
  auto table = std::make_shared<PanoramaTable>();
  const CubeRecord& cube = table->cube = cube_of(map);
  const std::int32_t side = std::max(1, record.width / cube.columns);
  if (record.width != side * cube.columns || record.height != side * cube.rows) {
    return absl::InvalidArgumentError(absl::StrCat(
        "camera: a cube map of layout ", v1::CubeMapCamera::Layout_Name(map.layout()), " has ", cube.columns,
        " x ", cube.rows, " square faces: a film of ", record.width, " x ", record.height,
        " pixels does not, one of ", side * cube.columns, " x ", side * cube.rows, " does"));
  }
  record.kind = SensorKind::kCubeMap;
  // A face spans two units.
  record.scale_x = 2 * static_cast<float>(cube.columns) / static_cast<float>(record.width);
  record.scale_y = 2 * static_cast<float>(cube.rows) / static_cast<float>(record.height);
  record.panorama = std::move(table);
  return absl::OkStatus();
}

}  // namespace

absl::Status set_all_around(const v1::Camera& camera, SensorRecord& record) {
  if (camera.screen_window_size() > 0)
    return absl::InvalidArgumentError("camera: those that see all around have no screen window");
  switch (camera.kind_case()) {
    case v1::Camera::kCylindrical:
      return set_cylinder(camera.cylindrical(), record);
    case v1::Camera::kPanorama:
      return set_panorama(camera, record);
    case v1::Camera::kCubeMap:
      return set_cube_map(camera.cube_map(), record);
    default:
      set_sphere(camera.spherical(), record);
      return absl::OkStatus();
  }
}

}  // namespace tessera::render
