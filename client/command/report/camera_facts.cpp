#include "command/report/camera_facts.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "import/geometry/transform.h"
#include "optics/lens_system.h"
#include "wire/exposure.h"
#include "wire/film_format.h"
#include "wire/lens_message.h"
#include "wire/viewpoint.h"

namespace tessera::client {
namespace {

constexpr const char* kFilmSize = "sensorOverallDimensions";

RowMatrix attribute_of(const Imath::M44d& matrix) {
  RowMatrix result;
  std::copy_n(matrix.getValue(), result.m.size(), result.m.begin());
  return result;
}

wire::PictureSize size_of(const Window& display) {
  return {static_cast<double>(display.width()), static_cast<double>(display.height())};
}

struct Screen {
  double x_min = -1, x_max = 1, y_min = -1, y_max = 1;
};

/// The part of the plane z = 1 that the display window shows.
Screen screen_of(const v1::Camera& camera, const Window& display) {
  if (camera.screen_window_size() == 4) {
    return {camera.screen_window(0), camera.screen_window(1), camera.screen_window(2),
            camera.screen_window(3)};
  }
  const double aspect = double{static_cast<double>(display.width())} / display.height();
  return aspect > 1 ? Screen{-aspect, aspect, -1, 1} : Screen{-1, 1, -1 / aspect, 1 / aspect};
}

/// Half of the picture's shorter side on the plane z = 1, the screen window being usual.
double half_side_of(const v1::Camera& camera, const Window& display) {
  if (camera.has_pinhole()) {
    const optics::FilmSize film = wire::film_size(camera.pinhole(), size_of(display));
    return std::min(film.width, film.height) / (2 * camera.pinhole().film_distance_mm());
  }
  return std::tan(wire::field_of_view(camera.perspective(), size_of(display)) * std::numbers::pi / 360);
}

/// NDC from camera space; third and fourth coordinates so that it can be inverted.
std::optional<Imath::M44d> projection_of(const v1::Camera& camera, const Window& display) {
  // A distorted film is no projection.
  if (camera.has_distortion()) return std::nullopt;
  if (!camera.has_perspective() && !camera.has_orthographic() && !camera.has_pinhole()) return std::nullopt;
  const Screen screen = screen_of(camera, display);
  const double width = screen.x_max - screen.x_min, height = screen.y_max - screen.y_min;
  if (camera.has_orthographic()) {
    return Imath::M44d(1 / width, 0, 0, 0, 0, -1 / height, 0, 0, 0, 0, 1, 0, -screen.x_min / width,
                       screen.y_max / height, 0, 1);
  }
  const double half_side = half_side_of(camera, display);
  const double near = camera.near_clip() > 0 ? camera.near_clip() : 1;
  const wire::WindowShift shift = wire::window_shift(camera);
  return Imath::M44d(1 / (width * half_side), 0, 0, 0, 0, -1 / (height * half_side), 0, 0,
                     -(screen.x_min + shift.x / half_side) / width,
                     (screen.y_max + shift.y / half_side) / height, 1, 1, 0, 0, -near, 0);
}

/// By OpenEXR's standard names, which say metres for the focus and millimetres for the focal length.
void add_lens_facts(const v1::LensCamera& camera, Image& image) {
  std::vector<optics::Fault> faults;
  const std::optional<optics::LensSystem> lens = wire::lens_system_of(camera, faults);
  if (!lens) return;  // a camera that no worker takes
  if (!camera.lens().name().empty()) image.metadata["lensModel"] = camera.lens().name();
  image.metadata["effectiveFocalLength"] = static_cast<float>(lens->paraxial().focal_length());
  image.metadata["aperture"] = static_cast<float>(lens->use().f_number);
  image.metadata["focus"] = static_cast<float>(lens->focus_distance() / 1000);
  image.metadata["entrancePupilOffset"] = static_cast<float>(lens->front() - lens->paraxial().entrance_pupil);
}

void add_hole_facts(const v1::PinholeCamera& camera, Image& image) {
  image.metadata["pinholeFocalLength"] = static_cast<float>(camera.film_distance_mm());
  image.metadata["aperture"] = static_cast<float>(camera.film_distance_mm() / camera.hole_mm());
}

NumberPair pair_of(const optics::FilmSize& size) {
  return {static_cast<float>(size.width), static_cast<float>(size.height)};
}

/// The size of the film, where the camera has one.
void add_film_size(const v1::Camera& camera, Image& image) {
  const wire::PictureSize picture = size_of(image.display);
  if (camera.has_lens()) {
    image.metadata[kFilmSize] = pair_of(wire::film_size(camera.lens(), picture));
  } else if (camera.has_pinhole()) {
    image.metadata[kFilmSize] = pair_of(wire::film_size(camera.pinhole(), picture));
  } else if (camera.perspective().focal_length_mm() > 0) {
    image.metadata["pinholeFocalLength"] = static_cast<float>(camera.perspective().focal_length_mm());
    const std::string& gauge = camera.perspective().film_gauge();
    image.metadata[kFilmSize] = pair_of(wire::film_size(0, gauge.empty() ? "full-frame" : gauge, picture));
  }
}

}  // namespace

void add_exposure_facts(const v1::Film& film, const std::string& words, const v1::Camera& camera,
                        Image& image) {
  const auto exposure = wire::film_exposure(film, words);
  if (!exposure.ok() || !exposure->photographic) return;
  const v1::PhotographicExposure& asked = *exposure->photographic;
  const auto add = [&](const char* name, double number) {
    image.metadata[name] = static_cast<float>(number);
  };
  if (asked.has_shutter_seconds()) add("expTime", asked.shutter_seconds());
  if (asked.has_iso()) add("isoSpeed", asked.iso());
  if (asked.has_f_number()) add("aperture", asked.f_number());
  if (asked.has_t_number()) add("tStop", asked.t_number());
  const auto scale = wire::exposure_scale(*exposure, camera);
  if (!scale.ok()) return;
  const bool takes_stop_of_lens = !asked.has_f_number() && !asked.has_t_number() && !asked.has_ev100();
  if (const auto lens = wire::lens_light(camera); takes_stop_of_lens && lens && lens->transmission < 1) {
    if (const auto aperture = image.metadata.find("aperture"); aperture != image.metadata.end())
      add("tStop", std::get<float>(aperture->second) / std::sqrt(lens->transmission));
  }
  // Pixels that are an illuminance have no luminance.
  if (wire::is_irradiance(camera)) return;
  add("whiteLuminance", (asked.cd_per_m2() > 0 ? asked.cd_per_m2() : 1) / *scale);
}

void add_luminance_facts(const v1::Scene& scene, const std::string& words, const v1::Camera& camera,
                         Image& image) {
  const double cd_per_m2 = scene.units().cd_per_m2();
  if (!(cd_per_m2 > 0) || wire::is_irradiance(camera)) return;
  const auto exposure = wire::film_exposure(scene.film(), words);
  if (!exposure.ok()) return;
  const auto scale = wire::exposure_scale(*exposure, camera);
  if (scale.ok() && *scale > 0) image.metadata["whiteLuminance"] = static_cast<float>(cd_per_m2 / *scale);
}

void add_camera_facts(const v1::Camera& camera, Image& image) {
  if (camera.has_lens()) add_lens_facts(camera.lens(), image);
  if (!camera.view_name().empty()) image.metadata["view"] = camera.view_name();
  if (camera.has_pinhole()) add_hole_facts(camera.pinhole(), image);
  add_film_size(camera, image);
  const std::optional<Imath::M44d> camera_from_world =
      inverse(matrix_of(wire::camera_from_viewpoint(camera)) * matrix_of(camera.world_from_camera()));
  if (!camera_from_world) return;
  image.metadata["worldToCamera"] = attribute_of(*camera_from_world);
  if (const auto projection = projection_of(camera, image.display))
    image.metadata["worldToNDC"] = attribute_of(*camera_from_world * *projection);
}

}  // namespace tessera::client
