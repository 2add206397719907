#include "capture/camera_rays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "google/protobuf/io/tokenizer.h"
#include "google/protobuf/text_format.h"
#include "wire/viewpoint.h"

namespace tessera::client {
namespace {

using light_field::Matrix4;
using light_field::Ray;

constexpr double kPi = std::numbers::pi;

/// From the film to camera space: x = left + step_x (column + 0.5), y = top - step_y (row + 0.5).
struct FilmWindow {
  double left = -1, top = 1, step_x = 0, step_y = 0;
};

FilmWindow film_window(const v1::Camera& camera, const ViewSize& size, double half_side) {
  const double aspect = static_cast<double>(size.width) / size.height;
  std::array<double, 4> w = {-std::max(aspect, 1.0), std::max(aspect, 1.0), -std::max(1 / aspect, 1.0),
                             std::max(1 / aspect, 1.0)};
  if (camera.screen_window_size() == 4) std::ranges::copy(camera.screen_window(), w.begin());
  return {w[0] * half_side, w[3] * half_side, (w[1] - w[0]) * half_side / size.width,
          (w[3] - w[2]) * half_side / size.height};
}

/// The angle from the axis of what a fisheye of focal length 1 has at this distance from the film's middle;
/// beyond what it sees, a number above pi.
double fisheye_angle(v1::FisheyeCamera::Mapping mapping, double r) {
  switch (mapping) {
    case v1::FisheyeCamera::EQUISOLID:
      return r <= 2 ? 2 * std::asin(r / 2) : 2 * kPi;
    case v1::FisheyeCamera::STEREOGRAPHIC:
      return 2 * std::atan(r / 2);
    case v1::FisheyeCamera::ORTHOGRAPHIC:
      return r <= 1 ? std::asin(r) : 2 * kPi;
    default:
      return r;
  }
}

double fisheye_radius(v1::FisheyeCamera::Mapping mapping, double angle) {
  switch (mapping) {
    case v1::FisheyeCamera::EQUISOLID:
      return 2 * std::sin(angle / 2);
    case v1::FisheyeCamera::STEREOGRAPHIC:
      return 2 * std::tan(angle / 2);
    case v1::FisheyeCamera::ORTHOGRAPHIC:
      return std::sin(angle);
    default:
      return angle;
  }
}

/// A ray of camera space for the middle of a pixel.
using PixelRay = std::function<Ray(double column, double row)>;

PixelRay perspective_ray(const v1::Camera& camera, const ViewSize& size) {
  FilmWindow film = film_window(camera, size, std::tan(camera.perspective().fov_degrees() * kPi / 360));
  const wire::WindowShift shift = wire::window_shift(camera);
  film.left += shift.x, film.top += shift.y;
  return [film](double column, double row) {
    return Ray{{0, 0, 0}, {film.left + film.step_x * column, film.top - film.step_y * row, 1}};
  };
}

PixelRay orthographic_ray(const v1::Camera& camera, const ViewSize& size) {
  const FilmWindow film = film_window(camera, size, 1);
  return [film](double column, double row) {
    return Ray{{film.left + film.step_x * column, film.top - film.step_y * row, 0}, {0, 0, 1}};
  };
}

PixelRay fisheye_ray(const v1::Camera& camera, const ViewSize& size) {
  const v1::FisheyeCamera& fisheye = camera.fisheye();
  const FilmWindow film =
      film_window(camera, size, fisheye_radius(fisheye.mapping(), fisheye.fov_degrees() * kPi / 360));
  const double circle = fisheye.circle_degrees() > 0 ? fisheye.circle_degrees() * kPi / 360 : kPi;
  return [film, circle, mapping = fisheye.mapping()](double column, double row) {
    const double x = film.left + film.step_x * column, y = film.top - film.step_y * row;
    const double r = std::hypot(x, y), angle = fisheye_angle(mapping, r);
    if (angle > circle) return Ray{};  // beyond the circle the film is black
    const double part = r > 0 ? std::sin(angle) / r : 1;
    return Ray{{0, 0, 0}, {part * x, part * y, std::cos(angle)}};
  };
}

PixelRay panorama_ray(const v1::Camera& camera, const ViewSize& size) {
  const v1::PanoramaCamera& panorama = camera.panorama();
  const auto radians = [](bool given, double degrees, double usual) {
    return (given ? degrees : usual) * kPi / 180;
  };
  const double left = radians(panorama.has_longitude_min_degrees(), panorama.longitude_min_degrees(), -180);
  const double right = radians(panorama.has_longitude_max_degrees(), panorama.longitude_max_degrees(), 180);
  const double low = radians(panorama.has_latitude_min_degrees(), panorama.latitude_min_degrees(), -90);
  const double high = radians(panorama.has_latitude_max_degrees(), panorama.latitude_max_degrees(), 90);
  return [=](double column, double row) {
    const double longitude = std::lerp(left, right, column / size.width);
    const double latitude = std::lerp(high, low, row / size.height);
    return Ray{{0, 0, 0},
               {std::cos(latitude) * std::sin(longitude), std::sin(latitude),
                std::cos(latitude) * std::cos(longitude)}};
  };
}

PixelRay spherical_ray(const ViewSize& size) {
  return [size](double column, double row) {
    const double phi = 2 * kPi * column / size.width, theta = kPi * row / size.height;
    return Ray{{0, 0, 0},
               {std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)}};
  };
}

absl::Status refuse(const std::string& what) {
  return absl::InvalidArgumentError(
      absl::StrCat("camera: ", what,
                   "; pictures are looked up for perspective (with fov_degrees), orthographic, fisheye, "
                   "panorama and spherical (EQUIRECTANGULAR) cameras without distortion"));
}

absl::StatusOr<PixelRay> pixel_ray(const v1::Camera& camera, const ViewSize& size) {
  if (camera.has_distortion()) return refuse("it has a distortion");
  if (camera.screen_window_size() != 0 && camera.screen_window_size() != 4)
    return refuse("a screen window has four numbers");
  if (camera.has_perspective() && camera.perspective().fov_degrees() > 0)
    return perspective_ray(camera, size);
  if (camera.has_orthographic()) return orthographic_ray(camera, size);
  if (camera.has_fisheye() && camera.fisheye().fov_degrees() > 0) return fisheye_ray(camera, size);
  if (camera.has_panorama() && camera.viewpoint().x() == 0) return panorama_ray(camera, size);
  if (camera.has_spherical() && camera.spherical().mapping() == v1::SphericalCamera::EQUIRECTANGULAR)
    return spherical_ray(size);
  return refuse("it is none whose rays are known here");
}

/// The first fault of a text form.
class FirstFault final : public google::protobuf::io::ErrorCollector {
 public:
  void AddError(int line, google::protobuf::io::ColumnNumber column, const std::string& message) override {
    if (text_.empty()) text_ = absl::StrCat(line + 1, ":", column + 1, ": ", message);
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace

absl::StatusOr<RayRow> camera_rays(const v1::Camera& camera, const ViewSize& size) {
  Matrix4 world_from_camera{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  if (camera.world_from_camera().elements_size() == 16)
    std::ranges::copy(camera.world_from_camera().elements(), world_from_camera.begin());
  else if (camera.world_from_camera().elements_size() != 0)
    return refuse("its matrix has not 16 elements");
  if (!light_field::inverse(world_from_camera)) return refuse("its matrix has no inverse");
  Matrix4 camera_from_eye{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  if (const v1::Matrix eye = wire::camera_from_viewpoint(camera); eye.elements_size() == 16)
    std::ranges::copy(eye.elements(), camera_from_eye.begin());
  auto ray = pixel_ray(camera, size);
  if (!ray.ok()) return ray.status();
  return RayRow(
      [world_from_camera, camera_from_eye, of_pixel = *std::move(ray)](std::uint32_t y, std::span<Ray> row) {
        for (std::size_t x = 0; x < row.size(); ++x) {
          const Ray in_eye = of_pixel(static_cast<double>(x) + 0.5, y + 0.5);
          row[x].origin = light_field::transformed_point(
              world_from_camera, light_field::transformed_point(camera_from_eye, in_eye.origin));
          row[x].direction = light_field::transformed_vector(
              world_from_camera, light_field::transformed_vector(camera_from_eye, in_eye.direction));
        }
      });
}

absl::StatusOr<v1::Camera> read_camera(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return absl::NotFoundError(absl::StrCat("there is no file ", path));
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  v1::Camera camera;
  FirstFault fault;
  google::protobuf::TextFormat::Parser parser;
  parser.RecordErrorsTo(&fault);
  if (!parser.ParseFromString(text, &camera))
    return absl::InvalidArgumentError(absl::StrCat(path, ":", fault.text()));
  return camera;
}

}  // namespace tessera::client
