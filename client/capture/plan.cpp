#include "capture/plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"

namespace tessera::client {
namespace {

using light_field::CameraGrid;
using light_field::ImageWindow;
using light_field::Matrix4;
using light_field::Pinhole;

/// Leaves a border about all that is in view.
constexpr double kMargin = 1.02;
/// Windows of cameras on the faces of a box end at this tangent.
constexpr double kWidestTangent = 16;
constexpr double kOutwardDegrees = 110;
/// The most views of a set: as many as a grid of 65 x 65.
constexpr std::uint64_t kMostCameras = 65 * 65 * 6;

double tangent(double fov_degrees) { return std::tan(fov_degrees * std::numbers::pi / 360); }

/// A window whose shorter side has this half.
ImageWindow window_about_axis(double half, const ViewSize& size) {
  const double shorter = std::min(size.width, size.height);
  const double x = half * size.width / shorter, y = half * size.height / shorter;
  return {-x, x, -y, y};
}

absl::StatusOr<ImageWindow> window_of_camera(const v1::Camera& camera, std::optional<double> fov_degrees,
                                             const ViewSize& size) {
  if (fov_degrees) return window_about_axis(tangent(*fov_degrees), size);
  if (!camera.has_perspective() || !(camera.perspective().fov_degrees() > 0)) {
    return absl::InvalidArgumentError(
        "the scene's camera has no field of view as that of a perspective: --fov says which the views have");
  }
  const double half = tangent(camera.perspective().fov_degrees());
  if (camera.screen_window_size() != 4) return window_about_axis(half, size);
  const auto& w = camera.screen_window();
  const ImageWindow window{half * w[0], half * w[1], half * w[2], half * w[3]};
  const double stretch = (window.x1 - window.x0) / (window.y1 - window.y0) * size.height / size.width;
  // Pixels stay square where the views have another shape than the film: the window is made narrower.
  const double x = stretch > 1 ? 1 / stretch : 1, y = stretch < 1 ? stretch : 1;
  const auto narrowed = [](double a, double b, double factor, double& low, double& high) {
    low = 0.5 * (a + b) - 0.5 * factor * (b - a), high = 0.5 * (a + b) + 0.5 * factor * (b - a);
  };
  ImageWindow result;
  narrowed(window.x0, window.x1, x, result.x0, result.x1);
  narrowed(window.y0, window.y1, y, result.y0, result.y1);
  return result;
}

/// The camera's axes, of unit length, and its place.
absl::StatusOr<Matrix4> axes_of(const v1::Camera& camera) {
  Matrix4 matrix{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  if (camera.world_from_camera().elements_size() == 16)
    std::ranges::copy(camera.world_from_camera().elements(), matrix.begin());
  for (std::size_t column = 0; column < 3; ++column) {
    const double length = std::hypot(matrix[column], matrix[4 + column], matrix[8 + column]);
    for (std::size_t row = 0; row < 3; ++row) matrix[4 * row + column] /= length;
  }
  if (!light_field::inverse(matrix)) return absl::InvalidArgumentError("the scene's camera has no place");
  return matrix;
}

absl::Status check_count(std::uint64_t cameras) {
  if (cameras > 0 && cameras <= kMostCameras) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("a light field has 1 to ", kMostCameras, " cameras, not ", cameras));
}

/// Adds the cameras of a grid; `window` gives that of each, by its place in the grid's plane.
template <class WindowOf>
void add_grid(CameraGrid grid, const ViewSize& size, const WindowOf& window, CapturePlan& plan) {
  grid.first_view = static_cast<std::uint32_t>(plan.cameras.size());
  for (std::uint32_t row = 0; row < grid.rows; ++row) {
    for (std::uint32_t column = 0; column < grid.columns; ++column) {
      const double x = (column - 0.5 * (grid.columns - 1)) * grid.spacing_x;
      const double y = (0.5 * (grid.rows - 1) - row) * grid.spacing_y;
      Pinhole& camera = plan.cameras.emplace_back();
      camera.world_from_camera = grid.world_from_grid;
      const Imath::V3d place = light_field::transformed_point(grid.world_from_grid, {x, y, 0});
      camera.world_from_camera[3] = place.x, camera.world_from_camera[7] = place.y;
      camera.world_from_camera[11] = place.z;
      light_field::set_window(window(x, y, camera), size.width, size.height, camera);
    }
  }
  plan.arrangement.grids.push_back(std::move(grid));
}

/// The window about all corners of a box before a camera.
ImageWindow window_about(const Imath::Box3d& box, const Pinhole& camera) {
  const Matrix4 from_world = *light_field::inverse(camera.world_from_camera);
  ImageWindow window{kWidestTangent, -kWidestTangent, kWidestTangent, -kWidestTangent};
  for (int corner = 0; corner < 8; ++corner) {
    const Imath::V3d p((corner & 1) != 0 ? box.max.x : box.min.x, (corner & 2) != 0 ? box.max.y : box.min.y,
                       (corner & 4) != 0 ? box.max.z : box.min.z);
    const Imath::V3d q = light_field::transformed_point(from_world, p);
    const double z = std::max(q.z, 1e-9 * box.size().length());
    const double x = std::clamp(q.x / z, -kWidestTangent, kWidestTangent);
    const double y = std::clamp(q.y / z, -kWidestTangent, kWidestTangent);
    window.x0 = std::min(window.x0, x), window.x1 = std::max(window.x1, x);
    window.y0 = std::min(window.y0, y), window.y1 = std::max(window.y1, y);
  }
  // A plane that is seen from its edge has no width, but for the border.
  const double x = 0.5 * (kMargin - 1) * (window.x1 - window.x0) + 1e-3;
  const double y = 0.5 * (kMargin - 1) * (window.y1 - window.y0) + 1e-3;
  return {window.x0 - x, window.x1 + x, window.y0 - y, window.y1 + y};
}

std::string text_of(const Imath::V3d& v) { return absl::StrFormat("%.4g,%.4g,%.4g", v.x, v.y, v.z); }

bool contains(const Imath::Box3d& outer, const Imath::Box3d& inner) {
  return outer.intersects(inner.min) && outer.intersects(inner.max);
}

/// Names what the box cuts, a few of it.
absl::Status check_cuts(const Imath::Box3d& box, const SceneBounds& bounds) {
  constexpr std::size_t kNamed = 5;
  std::vector<std::string> cut;
  for (const auto& [name, shape] : bounds.shapes) {
    if (!box.intersects(shape) || contains(box, shape)) continue;
    cut.push_back(absl::StrCat(name, " (", text_of(shape.min), " to ", text_of(shape.max), ")"));
  }
  if (cut.empty()) return absl::OkStatus();
  const std::size_t more = cut.size() > kNamed ? cut.size() - kNamed : 0;
  cut.resize(std::min(cut.size(), kNamed));
  return absl::InvalidArgumentError(absl::StrCat(
      "the box from ", text_of(box.min), " to ", text_of(box.max), " cuts ", absl::StrJoin(cut, "; "),
      more > 0 ? absl::StrCat("; and ", more, " more") : "", ": it has to be larger, or without them"));
}

/// Tells which parts of the scene lie in a box.
Imath::Box3d bounds_within(const Imath::Box3d& box, const SceneBounds& bounds) {
  Imath::Box3d inner;
  for (const auto& [name, shape] : bounds.shapes) {
    if (contains(box, shape)) inner.extendBy(shape);
  }
  return inner;
}

/// The grid of a face: axis 0 to 2, on the side of the largest coordinates or the least.
CameraGrid face_of(const Imath::Box3d& box, int axis, bool is_high, const BoxRequest& request,
                   const Uprightness& upright) {
  const Imath::V3d& up = upright.up;
  Imath::V3d normal(0);
  normal[axis] = is_high ? 1 : -1;
  Imath::V3d place = box.center();
  place[axis] = is_high ? box.max[axis] : box.min[axis];
  // An axis of the box is up, so that the grid lies along the face's edges.
  int up_axis = (axis + 1) % 3;
  for (int i = 0; i < 3; ++i) {
    if (i != axis && std::abs(up[i]) > std::abs(up[up_axis])) up_axis = i;
  }
  Imath::V3d y(0);
  y[up_axis] = up[up_axis] < 0 ? -1 : 1;
  CameraGrid grid;
  grid.name = absl::StrCat(is_high ? "+" : "-", std::string(1, "xyz"[axis]));
  grid.columns = request.columns, grid.rows = request.rows;
  grid.world_from_grid =
      light_field::looking(place, request.outwards ? normal : -normal, y, upright.mirrored);
  const Imath::V3d side = box.size();
  const double width = side[3 - axis - up_axis], height = side[up_axis];
  grid.spacing_x = width / std::max(request.columns - 1, 1u);
  grid.spacing_y = height / std::max(request.rows - 1, 1u);
  grid.focus = request.outwards ? side.length() : 0.5 * side[axis];
  return grid;
}

}  // namespace

absl::StatusOr<CapturePlan> plan_two_plane(const TwoPlaneRequest& request, const v1::Camera& middle,
                                           std::optional<double> fov_degrees, const ViewSize& size) {
  if (absl::Status s = check_count(std::uint64_t{request.columns} * request.rows); !s.ok()) return s;
  const auto window = window_of_camera(middle, fov_degrees, size);
  if (!window.ok()) return window.status();
  const auto axes = axes_of(middle);
  if (!axes.ok()) return axes.status();
  CapturePlan plan;
  CameraGrid grid;
  grid.name = "plane";
  grid.columns = request.columns, grid.rows = request.rows;
  grid.spacing_x = request.spacing_x, grid.spacing_y = request.spacing_y;
  grid.world_from_grid = *axes;
  grid.focus = request.focus;
  plan.arrangement.kind = "two-plane";
  plan.arrangement.target = light_field::transformed_point(*axes, {0, 0, request.focus});
  const auto sheared = [&](double x, double y, const Pinhole&) {
    const double u = x / request.focus, v = y / request.focus;
    return ImageWindow{window->x0 - u, window->x1 - u, window->y0 - v, window->y1 - v};
  };
  add_grid(std::move(grid), size, sheared, plan);
  return plan;
}

absl::StatusOr<CapturePlan> plan_sphere(const SphereRequest& request, const SceneBounds& bounds,
                                        const Uprightness& upright, std::optional<double> fov_degrees,
                                        const ViewSize& size) {
  if (absl::Status s = check_count(request.cameras); !s.ok()) return s;
  const bool has_bounds = !bounds.all.isEmpty() && std::isfinite(bounds.all.size().length());
  if (!has_bounds && !(request.target && request.radius && fov_degrees)) {
    return absl::InvalidArgumentError(
        "the scene has no bounds: --target, --radius and --fov say where the cameras stand");
  }
  const Imath::V3d target = request.target.value_or(has_bounds ? bounds.all.center() : Imath::V3d(0));
  const double ball =
      has_bounds ? (bounds.all.center() - target).length() + 0.5 * bounds.all.size().length() : 0;
  const double radius = request.radius.value_or(3 * ball);
  if (!(radius > 0) || (!fov_degrees && radius <= ball)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "cameras at a distance of %.4g stand within the ball around the scene, of radius %.4g", radius,
        ball));
  }
  const double half = fov_degrees ? tangent(*fov_degrees) : kMargin * std::tan(std::asin(ball / radius));
  CapturePlan plan;
  plan.arrangement.kind = "sphere";
  plan.arrangement.target = target;
  plan.arrangement.radius = radius;
  const Imath::V3d pole = upright.up.normalized();
  const Matrix4 axes = light_field::looking(Imath::V3d(0), pole, Imath::V3d(pole.y, pole.z, pole.x), false);
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (std::uint32_t i = 0; i < request.cameras; ++i) {
    const double z = 1 - (2.0 * i + 1) / request.cameras, r = std::sqrt(1 - z * z), phi = golden * i;
    const Imath::V3d away = light_field::transformed_vector(axes, {r * std::cos(phi), r * std::sin(phi), z});
    Pinhole& camera = plan.cameras.emplace_back();
    camera.world_from_camera = light_field::looking(target + radius * away, -away, pole, upright.mirrored);
    light_field::set_window(window_about_axis(half, size), size.width, size.height, camera);
  }
  return plan;
}

absl::StatusOr<CapturePlan> plan_box(const BoxRequest& request, const SceneBounds& bounds,
                                     const Uprightness& upright, std::optional<double> fov_degrees,
                                     const ViewSize& size) {
  if (absl::Status s = check_count(6 * std::uint64_t{request.columns} * request.rows); !s.ok()) return s;
  Imath::Box3d box;
  if (request.box) {
    box = *request.box;
  } else if (!bounds.all.isEmpty() && std::isfinite(bounds.all.size().length())) {
    const Imath::V3d half = 0.625 * bounds.all.size() + Imath::V3d(0.01 * bounds.all.size().length());
    box = Imath::Box3d(bounds.all.center() - half, bounds.all.center() + half);
  }
  if (box.isEmpty() || !(std::min({box.size().x, box.size().y, box.size().z}) > 0))
    return absl::InvalidArgumentError("the box is none: its second corner has the larger coordinates");
  const Imath::Box3d inner = bounds_within(box, bounds);
  if (!request.outwards) {
    if (absl::Status s = check_cuts(box, bounds); !s.ok()) return s;
    if (inner.isEmpty())
      return absl::InvalidArgumentError(
          absl::StrCat("there is nothing in the box from ", text_of(box.min), " to ", text_of(box.max)));
  }
  CapturePlan plan;
  plan.arrangement.kind = "box";
  plan.arrangement.target = box.center();
  plan.arrangement.box_low = box.min, plan.arrangement.box_high = box.max;
  const auto window = [&](double, double, const Pinhole& camera) {
    if (request.outwards) return window_about_axis(tangent(fov_degrees.value_or(kOutwardDegrees)), size);
    return fov_degrees ? window_about_axis(tangent(*fov_degrees), size) : window_about(inner, camera);
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool is_high : {true, false})
      add_grid(face_of(box, axis, is_high, request, upright), size, window, plan);
  }
  return plan;
}

Uprightness uprightness_of(const v1::Camera& camera) {
  Uprightness upright;
  const auto axes = axes_of(camera);
  if (!axes.ok()) return upright;
  upright.up = light_field::transformed_vector(*axes, {0, 1, 0});
  upright.mirrored = light_field::mirrors(*axes);
  return upright;
}

void set_cameras(const std::vector<Pinhole>& cameras, const ViewSize& size, v1::Scene& scene) {
  v1::Camera common;
  common.set_medium(scene.camera().medium());
  if (scene.camera().has_shutter()) *common.mutable_shutter() = scene.camera().shutter();
  common.mutable_perspective()->set_fov_degrees(90);  // units of the screen window are those of z = 1
  scene.clear_views();
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    v1::Camera& camera = i == 0 ? *scene.mutable_camera() : *scene.add_views();
    camera = common;
    for (const double element : cameras[i].world_from_camera)
      camera.mutable_world_from_camera()->add_elements(element);
    const ImageWindow window = light_field::window_of(cameras[i], size.width, size.height);
    for (const double border : {window.x0, window.x1, window.y0, window.y1})
      camera.add_screen_window(static_cast<float>(border));
  }
}

CaptureSize size_of_capture(std::size_t views, const ViewSize& size, bool half) {
  CaptureSize result;
  result.pixels = std::uint64_t{views} * size.width * size.height;
  result.disk = result.pixels * (half ? 4 * 2 + 4 : 5 * 4);
  // Red, green, blue, alpha and depth of all views until the job is done, and results that wait.
  result.memory = result.pixels * 5 * sizeof(float) + (std::uint64_t{256} << 20);
  return result;
}

absl::Status check_size(std::size_t views, const ViewSize& size, bool half, std::uint64_t free_disk,
                        std::uint64_t free_memory) {
  const CaptureSize need = size_of_capture(views, size, half);
  if (need.disk <= free_disk && need.memory <= free_memory) return absl::OkStatus();
  const auto gigabytes = [](std::uint64_t bytes) {
    return absl::StrFormat("%.3g GB", 1e-9 * static_cast<double>(bytes));
  };
  const bool on_disk = need.disk > free_disk;
  const double share = on_disk ? static_cast<double>(free_disk) / static_cast<double>(need.disk)
                               : static_cast<double>(free_memory) / static_cast<double>(need.memory);
  const auto side = static_cast<std::uint64_t>(std::sqrt(0.9 * share * static_cast<double>(views)));
  const double shrink = std::sqrt(0.9 * share);
  return absl::OutOfRangeError(absl::StrCat(
      views, " views of ", size.width, "x", size.height, " pixels take up to ",
      gigabytes(on_disk ? need.disk : need.memory), on_disk ? " on disk" : " of memory", ", and there are ",
      gigabytes(on_disk ? free_disk : free_memory), ": ", side * side, " views of this size would fit (",
      side, "x", side, "), or all at ", static_cast<std::uint64_t>(shrink * size.width), "x",
      static_cast<std::uint64_t>(shrink * size.height)));
}

}  // namespace tessera::client
