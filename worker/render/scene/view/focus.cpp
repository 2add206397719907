#include "render/scene/view/focus.h"

#include <cmath>
#include <cstddef>
#include <optional>

#include "absl/strings/str_cat.h"
#include "optics/image_quality.h"
#include "render/bsdf/kinds.h"
#include "render/core/vec64.h"
#include "render/scene/view/distorted_film.h"
#include "render/scene/view/lens.h"
#include "render/sensor/lens_table.h"
#include "wire/lens_message.h"

namespace tessera::render {

namespace {

using vec64::Vec;

/// A ray of sensor space; the direction's z is above 0.
struct SensorSpaceRay {
  Vec origin, direction;
};

class FocusRays {
 public:
  FocusRays(const SensorRecord& sensor, const SceneArrays& arrays, const RayQuery& rays)
      : sensor_(sensor),
        pose_(sensor.steps.empty() ? sensor.render_from_sensor : sensor.steps.front()),
        arrays_(arrays),
        rays_(rays) {}

  /// The depth, in sensor space, of what the ray hits first within the camera's clipping distances.
  std::optional<double> depth_along(const SensorSpaceRay& ray) const {
    const Vec way = transformed(ray.direction);
    const double length = std::sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
    const Vec direction = way * (1 / length), origin = transformed(ray.origin) + place();
    const double depth_per_length = ray.direction[2] / length;
    const double unit_of_depth = length_of_axis();
    double at = sensor_.near_clip > 0 ? sensor_.near_clip / (unit_of_depth * depth_per_length) : 0;
    constexpr int kMostBorders = 64;
    constexpr double kApart = 1e-4;  // rays stay apart from a border by this part of the distance to it
    for (int i = 0; i < kMostBorders; ++i) {
      const std::optional<FirstHit> next = first_hit(origin + direction * at, direction);
      if (!next) return std::nullopt;
      at += next->distance;
      if (!next->border) break;
      at *= 1 + kApart;
    }
    const double depth = at * depth_per_length;
    if (sensor_.far_clip > 0 && depth * unit_of_depth > sensor_.far_clip) return std::nullopt;
    return ray.origin[2] + depth;
  }

 private:
  struct FirstHit {
    double distance;
    bool border;  // of media alone
  };

  Vec transformed(const Vec& v) const {
    const float* const m = pose_.m;
    return {m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[4] * v[0] + m[5] * v[1] + m[6] * v[2],
            m[8] * v[0] + m[9] * v[1] + m[10] * v[2]};
  }
  Vec place() const { return {double{pose_.m[3]}, double{pose_.m[7]}, double{pose_.m[11]}}; }
  double length_of_axis() const {
    return std::hypot(double{pose_.m[2]}, double{pose_.m[6]}, double{pose_.m[10]});
  }

  std::optional<FirstHit> first_hit(const Vec& origin, const Vec& direction) const {
    constexpr std::size_t kPacket = 16;
    alignas(64) float o[3][kPacket] = {}, d[3][kPacket] = {}, t[kPacket] = {}, u[kPacket] = {},
                      v[kPacket] = {};
    alignas(64) float time[kPacket] = {};
    alignas(64) std::int32_t primitive[kPacket] = {}, shape[kPacket] = {}, instance[kPacket] = {},
                             upper[kPacket] = {};
    for (std::size_t a = 0; a < 3; ++a) {
      o[a][0] = static_cast<float>(origin[a]);
      d[a][0] = static_cast<float>(direction[a]);
    }
    HitArrays hits{t, u, v, primitive, shape, instance};
    hits.upper = upper;
    rays_.nearest({o[0], o[1], o[2], d[0], d[1], d[2], time}, 1, false, hits);
    if (shape[0] < 0) return std::nullopt;
    const std::int32_t material = arrays_.shapes.shapes[static_cast<std::size_t>(shape[0])].material;
    const bool border =
        material >= 0 && arrays_.materials.materials[static_cast<std::size_t>(material)].kind == kNoSurface;
    return FirstHit{double{t[0]}, border};
  }

  const SensorRecord& sensor_;
  const Affine& pose_;
  const SceneArrays& arrays_;
  const RayQuery& rays_;
};

absl::Status nothing_there(const v1::FocusPoint& point) {
  return absl::InvalidArgumentError(absl::StrCat("camera: there is nothing to focus on at ", point.x(), ", ",
                                                 point.y(), " of the picture (focus_point)"));
}

/// The ray in the middle of those that come to a place of the film (mm); nothing where there are none.
std::optional<SensorSpaceRay> middle_ray(const optics::LensSystem& lens, double film_x, double film_y,
                                         double units_per_mm) {
  const double height = std::hypot(film_x, film_y);
  const auto principal = optics::principal_ray(lens, height, optics::kLineD);
  if (!principal) return std::nullopt;
  const auto out = lens.unstopped(*principal, optics::kLineD);
  if (!out || !(out->direction.z > 0)) return std::nullopt;
  const double c = height > 0 ? film_x / height : 1, s = height > 0 ? film_y / height : 0;
  const auto turned = [&](const optics::Vector& v) { return Vec{v.x * c - v.y * s, v.x * s + v.y * c, v.z}; };
  return SensorSpaceRay{turned(out->origin) * units_per_mm, turned(out->direction)};
}

absl::Status focus_lens_system(const SensorRecord& sensor, double place_x, double place_y,
                               const FocusRays& rays, v1::Camera& camera) {
  v1::LensCamera& message = *camera.mutable_lens();
  const double units_per_mm = 1 / wire::mm_per_unit(message);
  // The picture on the film is upside down, and where it is does not depend on the focus.
  const double film_x = -place_x * sensor.lens->film_distance, film_y = -place_y * sensor.lens->film_distance;
  message.set_focus_distance(0);
  double distance = 0;
  constexpr int kMostSteps = 32;
  constexpr double kEnough = 1e-6;
  for (int i = 0; i < kMostSteps; ++i) {
    const auto lens = focus_lens(message);
    if (!lens.ok()) return absl::InvalidArgumentError(absl::StrCat("camera: ", lens.status().message()));
    const auto ray = middle_ray(lens->system, film_x, film_y, units_per_mm);
    const std::optional<double> depth = ray ? rays.depth_along(*ray) : std::nullopt;
    if (!depth && i == 0) return nothing_there(camera.focus_point());
    if (!depth || std::abs(*depth - distance) <= kEnough * distance) break;
    distance = *depth;
    message.set_focus_distance(distance);
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status focus_on_point(const SensorRecord& sensor, const SceneArrays& arrays, const RayQuery& rays,
                            v1::Camera& camera) {
  const FocusRays focus(sensor, arrays, rays);
  const v1::FocusPoint& point = camera.focus_point();
  const double x = double{sensor.scale_x} * point.x() * sensor.width + sensor.offset_x,
               y = double{sensor.scale_y} * point.y() * sensor.height + sensor.offset_y;
  if (camera.has_lens()) return focus_lens_system(sensor, x, y, focus, camera);
  const PlanePoint seen =
      sensor.distortion == nullptr ? PlanePoint{x, y} : undistorted(*sensor.distortion, {x, y});
  const bool parallel = camera.has_orthographic();
  const auto depth = focus.depth_along(parallel ? SensorSpaceRay{{seen.x, seen.y, 0}, {0, 0, 1}}
                                                : SensorSpaceRay{{0, 0, 0}, {seen.x, seen.y, 1}});
  if (!depth) return nothing_there(point);
  if (parallel) {
    camera.mutable_orthographic()->set_focal_distance(static_cast<float>(*depth));
    return absl::OkStatus();
  }
  double distance = *depth;
  if (sensor.kind == SensorKind::kTiltedLens) {
    // The plane of focus goes through the point, not through that of this depth on the axis.
    const float* const plane = sensor.lens->tilt.plane;
    const double rest = 1 - *depth * (plane[0] * seen.x + plane[1] * seen.y);
    if (!(rest > 0))
      return absl::InvalidArgumentError(
          "camera: its lens is tilted so much that no focus is sharp at its focus_point");
    distance /= rest;
  }
  camera.mutable_perspective()->set_focal_distance(static_cast<float>(distance));
  return absl::OkStatus();
}

}  // namespace tessera::render
