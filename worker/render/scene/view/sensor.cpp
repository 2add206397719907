#include "render/scene/view/sensor.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "render/scene/placement/motion.h"
#include "render/scene/values/located.h"
#include "render/scene/view/all_around.h"
#include "render/scene/view/aperture.h"
#include "render/scene/view/distortion.h"
#include "render/scene/view/hole.h"
#include "render/scene/view/lens.h"
#include "render/scene/view/lens_faults.h"
#include "render/scene/view/probes.h"
#include "render/scene/view/shutter.h"
#include "render/scene/view/viewpoint.h"
#include "render/sensor/lens_table.h"
#include "wire/film_format.h"

namespace tessera::render {

namespace {

/// `viewpoint`: to camera space.
absl::Status set_camera_motion(const v1::Camera& camera, const Transform& viewpoint, const RenderSpace& space,
                               SensorRecord& record) {
  const auto motion = Motion::of(camera);
  if (!motion.ok()) return motion.status();
  if (!motion->moves()) return absl::OkStatus();
  const auto pose = [&](double time) {
    const Transform render_from_camera = space.from_world * motion->at(time);
    return camera.has_viewpoint() ? render_from_camera * viewpoint : render_from_camera;
  };
  return append_steps(pose, motion->segments(), record.steps);
}

/// The film's window on the screen; `half_side`: of the screen whose shorter side spans [-1, 1], in camera
/// space.
absl::Status set_screen(const v1::Camera& camera, FilmSize film, double half_side, SensorRecord& record) {
  const double width = film.width, height = film.height;
  double x_min = -1, x_max = 1, y_min = -1, y_max = 1;
  if (camera.screen_window_size() == 4) {
    x_min = camera.screen_window(0), x_max = camera.screen_window(1);
    y_min = camera.screen_window(2), y_max = camera.screen_window(3);
  } else if (camera.screen_window_size() == 0) {
    const double aspect = width / height;
    if (aspect > 1) {
      x_min = -aspect, x_max = aspect;
    } else {
      y_min = -1 / aspect, y_max = 1 / aspect;
    }
  } else {
    return absl::InvalidArgumentError("camera: a screen window has four numbers");
  }
  record.scale_x = static_cast<float>((x_max - x_min) / width * half_side);
  record.scale_y = static_cast<float>((y_min - y_max) / height * half_side);
  record.offset_x = static_cast<float>(x_min * half_side);
  record.offset_y = static_cast<float>(y_max * half_side);
  if (!std::isfinite(record.scale_x + record.scale_y + record.offset_x + record.offset_y)) {
    return absl::InvalidArgumentError("camera: its screen window is not finite");
  }
  return absl::OkStatus();
}

/// `lens`: a message that has a lens_radius, a focal_distance and an aperture; it is sound.
template <class CameraKind>
absl::Status set_lens(const CameraKind& lens, const LensSurroundings& surroundings, SensorRecord& record) {
  // Where a point of the picture says what is sharp, any distance serves until the scene is there.
  const float radius = lens.lens_radius(),
              focal_distance =
                  surroundings.focused_later && !(lens.focal_distance() > 0) ? 1 : lens.focal_distance();
  const v1::LensAperture& aperture = lens.aperture();
  record.lens_radius = radius;
  record.focal_distance = focal_distance;
  if (radius == 0) return absl::OkStatus();
  record.kind = with_lens(record.kind);
  record.has_barrel = aperture.barrel_length() > 0;
  if (!aperture.has_blades() && !aperture.has_ratio() && !aperture.has_image() && !record.has_barrel)
    return absl::OkStatus();
  auto table = std::make_shared<LensTable>();
  table->aperture =
      aperture_of(aperture.blades(), aperture.blade_degrees(), aperture.has_ratio() ? aperture.ratio() : 1);
  table->barrel_length = static_cast<float>(aperture.barrel_length());
  if (aperture.has_barrel_radius()) table->barrel_radius = static_cast<float>(aperture.barrel_radius());
  if (aperture.has_image() && surroundings.blobs != nullptr) {
    auto picture = aperture_picture(aperture.image(), *surroundings.blobs);
    if (!picture.ok()) return located(picture.status(), "camera");
    table->picture = *std::move(picture);
  }
  record.lens = std::move(table);
  return absl::OkStatus();
}

absl::Status check_for_algorithm(const v1::Camera& camera, FilmSize film,
                                 const wire::AlgorithmTraits& algorithm) {
  if (camera.has_lens() && algorithm.blindness == wire::Blindness::kMirrorImages) {
    return absl::InvalidArgumentError(absl::StrCat(
        "integrator '", algorithm.name,
        "' joins points of the scene to the camera, and which ray leads there through a lens system "
        "is not known; 'path' and all others begin at the film"));
  }
  if (algorithm.work == wire::WorkKind::kPasses &&
      std::uint64_t{film.width} * film.height > (std::uint64_t{1} << 30)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "integrator '", algorithm.name, "' works on all pixels of the film at once; 2^30 are the most"));
  }
  return absl::OkStatus();
}

/// Distance on the film from its middle, in focal lengths, of what is seen at this angle (radians) from the
/// axis; nothing where that is never seen.
std::optional<double> fisheye_distance(v1::FisheyeCamera::Mapping mapping, double angle) {
  constexpr double kPi = std::numbers::pi;
  switch (mapping) {
    case v1::FisheyeCamera::EQUISOLID:
      return angle <= kPi ? std::optional(2 * std::sin(angle / 2)) : std::nullopt;
    case v1::FisheyeCamera::STEREOGRAPHIC:
      return angle < 0.99 * kPi ? std::optional(2 * std::tan(angle / 2)) : std::nullopt;
    case v1::FisheyeCamera::ORTHOGRAPHIC:
      return angle <= kPi / 2 ? std::optional(std::sin(angle)) : std::nullopt;
    default:
      return angle <= kPi ? std::optional(angle) : std::nullopt;
  }
}

SensorKind kind_of(v1::FisheyeCamera::Mapping mapping) {
  switch (mapping) {
    case v1::FisheyeCamera::EQUISOLID:
      return SensorKind::kFisheyeEquisolid;
    case v1::FisheyeCamera::STEREOGRAPHIC:
      return SensorKind::kFisheyeStereographic;
    case v1::FisheyeCamera::ORTHOGRAPHIC:
      return SensorKind::kFisheyeOrthographic;
    default:
      return SensorKind::kFisheyeEquidistant;
  }
}

absl::Status set_fisheye(const v1::Camera& camera, FilmSize film, SensorRecord& record) {
  const v1::FisheyeCamera& fisheye = camera.fisheye();
  constexpr double kHalfOfDegree = std::numbers::pi / 360;
  const double fov = fisheye.fov_degrees(), circle = fisheye.circle_degrees();
  const std::optional<double> half_side = fisheye_distance(fisheye.mapping(), fov * kHalfOfDegree);
  if (!(fov > 0) || !half_side) {
    return absl::InvalidArgumentError(absl::StrCat("camera: a fisheye of mapping ",
                                                   v1::FisheyeCamera::Mapping_Name(fisheye.mapping()),
                                                   " cannot see a field of ", fov, " degrees"));
  }
  if (!(circle >= 0 && circle <= 360)) {
    return absl::InvalidArgumentError(
        absl::StrCat("camera: a circle of ", circle, " degrees is not in (0, 360], nor 0, which is none"));
  }
  record.kind = kind_of(fisheye.mapping());
  if (circle > 0) record.circle_angle = static_cast<float>(circle * kHalfOfDegree);
  return set_screen(camera, film, *half_side, record);
}

/// Half of the film's shorter side. `camera`: a message that has a film's diagonal and gauge.
template <class CameraKind>
double half_film_mm(const CameraKind& camera, FilmSize film) {
  const optics::FilmSize size =
      wire::film_size(camera, {static_cast<double>(film.width), static_cast<double>(film.height)});
  return std::min(size.width, size.height) / 2;
}

absl::Status set_hole(const v1::Camera& camera, FilmSize film, bool spectral, SensorRecord& record) {
  const v1::PinholeCamera& pinhole = camera.pinhole();
  if (auto s = check_hole(pinhole); !s.ok()) return located(s, "camera");
  const double half_side = half_film_mm(pinhole, film) / pinhole.film_distance_mm();
  if (auto s = set_screen(camera, film, half_side, record); !s.ok()) return s;
  record.kind = SensorKind::kHole;
  record.hole = hole_table(pinhole, spectral);
  record.disperses = record.hole->wavelengths > 1;
  return absl::OkStatus();
}

/// Light that is sent into the lens starts where rays from the film end, and is weighed by angles.
absl::Status check_light_into_lens(const v1::Camera& camera, const SensorRecord& record) {
  if (camera.near_clip() > 0 || camera.far_clip() > 0)
    return absl::InvalidArgumentError("camera: clipping distances do not go with lens_ghosts 'lights'");
  if (camera.has_distortion() || camera.has_shutter())
    return absl::InvalidArgumentError(
        "camera: neither a distortion nor a shutter of its own goes with lens_ghosts 'lights'");
  const float* const m = record.render_from_sensor.m;
  double lengths[3];
  for (int a = 0; a < 3; ++a) lengths[a] = std::hypot(m[a], m[4 + a], m[8 + a]);
  const auto [least, most] = std::minmax_element(std::begin(lengths), std::end(lengths));
  if (*most > *least * 1.0001)
    return absl::InvalidArgumentError(
        "camera: a transform that stretches does not go with lens_ghosts 'lights'");
  return absl::OkStatus();
}

absl::Status set_lens_system(const v1::Camera& camera, FilmSize film, bool spectral,
                             const LensSurroundings& surroundings, SensorRecord& record) {
  const auto lens = focus_lens(camera.lens());
  if (!lens.ok()) return located(lens.status(), "camera");
  const double half_side = half_film_mm(camera.lens(), film) / lens->film_distance;
  if (auto s = set_screen(camera, film, half_side, record); !s.ok()) return s;
  record.kind = SensorKind::kLensSystem;
  record.disperses = spectral && (lens->system.disperses() || camera.lens().ghosts());
  if (camera.lens().ghosts() && surroundings.takes_light) {
    if (auto s = check_light_into_lens(camera, record); !s.ok()) return s;
  }
  auto table = lens_table(camera.lens(), *lens, record, surroundings);
  if (!table.ok()) return located(table.status(), "camera");
  record.lens = *std::move(table);
  return absl::OkStatus();
}

/// Tilts a thin lens whose radius, focal distance and aperture are set, before a film whose places are.
absl::Status set_tilt(const v1::LensTilt& tilt, SensorRecord& record) {
  const double x = tilt.x_degrees() * std::numbers::pi / 180, y = tilt.y_degrees() * std::numbers::pi / 180;
  const double focal_length = tilt.focal_length(), distance = record.focal_distance;
  if (!(std::abs(tilt.x_degrees()) < 90 && std::abs(tilt.y_degrees()) < 90)) {
    return absl::InvalidArgumentError(
        absl::StrCat("camera: a lens is tilted by less than 90 degrees, not by ", tilt.x_degrees(), " and ",
                     tilt.y_degrees()));
  }
  if (!(focal_length > 0))
    return absl::InvalidArgumentError("camera: a lens that is tilted needs a focal length above 0");
  if (record.has_barrel)
    return absl::InvalidArgumentError(
        "camera: a lens that is tilted has no barrel: cat's eyes are of others");
  if (record.lens_radius == 0) return absl::OkStatus();
  const double cx = std::cos(x), sx = std::sin(x), cy = std::cos(y), sy = std::sin(y);
  const Imath::V3d axis(sy * cx, sx, cy * cx), across_x(cy, 0, -sy), across_y(-sy * sx, cx, -cy * sx);
  if (!(axis.z * distance > focal_length)) {
    return absl::InvalidArgumentError(absl::StrCat("camera: a lens with a focal length of ", focal_length,
                                                   " that is tilted so much cannot focus at ", distance,
                                                   ", but only beyond ", focal_length / axis.z));
  }
  // The thin lens equation along the lens's axis [Scheimpflug 1904; Merklinger 1996].
  const Imath::V3d plane(axis.x / focal_length, axis.y / focal_length, 1 / distance);
  auto table = record.lens ? std::make_shared<LensTable>(*record.lens) : std::make_shared<LensTable>();
  const double widest = std::max(1.0, double{table->aperture.width}) * record.lens_radius;
  if (!(std::hypot(plane ^ across_x, plane ^ across_y) * widest < 1)) {
    return absl::InvalidArgumentError(
        "camera: its lens is tilted so much that the plane of focus passes through the lens");
  }
  for (const double column : {0.0, static_cast<double>(record.width)}) {
    for (const double row : {0.0, static_cast<double>(record.height)}) {
      const Imath::V3d corner(record.offset_x + column * record.scale_x,
                              record.offset_y + row * record.scale_y, 1);
      if (!((axis ^ corner) > 0)) {
        return absl::InvalidArgumentError(
            "camera: its lens is tilted so much that the film reaches through the plane of the lens");
      }
    }
  }
  for (int i = 0; i < 3; ++i) {
    table->tilt.across_x[i] = static_cast<float>(across_x[i]);
    table->tilt.across_y[i] = static_cast<float>(across_y[i]);
    table->tilt.plane[i] = static_cast<float>(plane[i]);
  }
  record.lens = std::move(table);
  record.kind = SensorKind::kTiltedLens;
  return absl::OkStatus();
}

absl::Status check_focus_point(const v1::Camera& camera) {
  const v1::FocusPoint& point = camera.focus_point();
  const auto is_part = [](double x) { return x >= 0 && x <= 1; };
  if (!is_part(point.x()) || !is_part(point.y()))
    return absl::InvalidArgumentError(absl::StrCat("camera: focus_point ", point.x(), ", ", point.y(),
                                                   " is not in the picture; 0 to 1 are its edges"));
  if (!camera.has_perspective() && !camera.has_orthographic() && !camera.has_lens())
    return absl::InvalidArgumentError(
        "camera: it has no lens that a focus_point could focus; perspective, orthographic and lens have");
  return absl::OkStatus();
}

absl::Status set_perspective(const v1::Camera& camera, FilmSize film, const LensSurroundings& surroundings,
                             SensorRecord& record) {
  const v1::PerspectiveCamera& perspective = camera.perspective();
  if (const auto fault = wire::field_fault(perspective))
    return absl::InvalidArgumentError(absl::StrCat("camera: ", *fault));
  const double fov =
      wire::field_of_view(perspective, {static_cast<double>(film.width), static_cast<double>(film.height)});
  const double half_side = std::tan(fov * std::numbers::pi / 360);
  if (auto s = set_screen(camera, film, half_side, record); !s.ok()) return s;
  if (auto s = set_lens(perspective, surroundings, record); !s.ok()) return s;
  return perspective.has_tilt() ? set_tilt(perspective.tilt(), record) : absl::OkStatus();
}

/// How the film lies before the camera, and its lens.
absl::Status set_projection(const v1::Camera& camera, FilmSize film, bool spectral,
                            const LensSurroundings& surroundings, SensorRecord& record) {
  switch (camera.kind_case()) {
    case v1::Camera::kPerspective:
      return set_perspective(camera, film, surroundings, record);
    case v1::Camera::kOrthographic:
      record.kind = SensorKind::kOrthographic;
      if (auto s = set_screen(camera, film, 1, record); !s.ok()) return s;
      return set_lens(camera.orthographic(), surroundings, record);
    case v1::Camera::kLens:
      return set_lens_system(camera, film, spectral, surroundings, record);
    case v1::Camera::kPinhole:
      return set_hole(camera, film, spectral, record);
    case v1::Camera::kFisheye:
      return set_fisheye(camera, film, record);
    case v1::Camera::kPanorama:
      if (auto s = set_all_around(camera, record); !s.ok()) return s;
      return set_lens(camera.panorama(), surroundings, record);
    case v1::Camera::kCylindrical:
    case v1::Camera::kSpherical:
    case v1::Camera::kCubeMap:
      return set_all_around(camera, record);
    case v1::Camera::kProbes:  // build_sensor() has seen to them
    case v1::Camera::KIND_NOT_SET:
      break;
  }
  return absl::InvalidArgumentError("camera: there is none, or its kind is unknown");
}

}  // namespace

absl::StatusOr<SensorRecord> build_sensor(const v1::Camera& camera, FilmSize film, const RenderSpace& space,
                                          const wire::AlgorithmTraits& algorithm, bool spectral,
                                          const LensSurroundings& surroundings) {
  const auto world_from_camera = Transform::from_proto(camera.world_from_camera());
  if (!world_from_camera.ok()) return located(world_from_camera.status(), "camera");
  if (world_from_camera->determinant() == 0)
    return absl::InvalidArgumentError("camera: its transform is singular");
  const auto viewpoint = camera_from_viewpoint(camera);
  if (!viewpoint.ok()) return viewpoint.status();
  SensorRecord record;
  const Transform render_from_camera = space.from_world * *world_from_camera;
  record.render_from_sensor =
      (camera.has_viewpoint() ? render_from_camera * *viewpoint : render_from_camera).to_affine();
  const absl::Status moved = located(set_camera_motion(camera, *viewpoint, space, record), "camera");
  auto shutter = build_shutter(camera.shutter(), film);
  if (!moved.ok() && !shutter.ok())
    return absl::InvalidArgumentError(absl::StrCat(moved.message(), "; ", shutter.status().message()));
  if (!moved.ok()) return moved;
  if (!shutter.ok()) return shutter.status();
  record.shutter = *std::move(shutter);
  record.near_clip = camera.near_clip();
  record.far_clip = camera.far_clip();
  if (!(record.near_clip >= 0) || !std::isfinite(record.near_clip) || !(record.far_clip >= 0) ||
      (record.far_clip > 0 && record.far_clip <= record.near_clip)) {
    return absl::InvalidArgumentError("camera: its clipping distances are not in order");
  }
  record.width = static_cast<std::int32_t>(film.width);
  record.height = static_cast<std::int32_t>(film.height);
  if (const std::vector<LensFault> faults = lens_faults_of(camera); !faults.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("camera: ", absl::StrJoin(faults, "; ", [](std::string* out, const LensFault& fault) {
                       out->append(fault.message);
                     })));
  }
  if (auto s = check_focus_point(camera); camera.has_focus_point() && !s.ok()) return s;
  if (auto s = check_for_algorithm(camera, film, algorithm); !s.ok()) return s;
  if (camera.has_probes()) {
    if (auto s = set_probes(camera, space, algorithm, surroundings.blobs, record); !s.ok()) return s;
    return record;
  }
  if (auto s = set_projection(camera, film, spectral, surroundings, record); !s.ok()) return s;
  move_window(camera, record);
  if (camera.has_distortion()) {
    auto distortion =
        distortion_table(camera, record, surroundings.blobs ? *surroundings.blobs : BlobSource{});
    if (!distortion.ok()) return distortion.status();
    record.distortion = *std::move(distortion);
  }
  return record;
}

}  // namespace tessera::render
