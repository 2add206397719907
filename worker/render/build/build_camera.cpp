#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "render/build/scene_builder.h"

namespace tessera::render {

Point render_origin(const v1::Scene& scene, const Transform& world_from_camera) {
  if (!scene.has_render_origin()) return world_from_camera.apply({0, 0, 0});
  return {scene.render_origin().x(), scene.render_origin().y(), scene.render_origin().z()};
}

absl::Status SceneBuilder::build_camera() {
  const v1::Camera& camera = scene_.camera();
  auto world_from_camera = Transform::from_proto(camera.world_from_camera());
  if (!world_from_camera.ok()) return located(world_from_camera.status(), "camera");
  if (world_from_camera->determinant() == 0)
    return absl::InvalidArgumentError("camera: its transform is singular");

  render_origin_ = render_origin(scene_, *world_from_camera);
  for (const double x : {render_origin_.x, render_origin_.y, render_origin_.z}) {
    if (!std::isfinite(x)) return absl::InvalidArgumentError("the scene's render_origin is not finite");
  }
  render_from_world_ = Transform::translation({-render_origin_.x, -render_origin_.y, -render_origin_.z});
  CameraRecord& record = tables_.camera;
  record.render_from_camera = (render_from_world_ * *world_from_camera).to_affine();
  if (!camera.world_from_camera_end().elements().empty()) {
    if (auto s = set_camera_motion(*world_from_camera); !s.ok()) return located(s, "camera");
  }

  record.near_clip = camera.near_clip();
  record.far_clip = camera.far_clip();
  if (!(record.near_clip >= 0) || !std::isfinite(record.near_clip) || !(record.far_clip >= 0) ||
      (record.far_clip > 0 && record.far_clip <= record.near_clip)) {
    return absl::InvalidArgumentError("camera: its clipping distances are not in order");
  }
  record.width = static_cast<std::int32_t>(job_.view().width());
  record.height = static_cast<std::int32_t>(job_.view().height());
  if (algorithm_->work == wire::WorkKind::kPasses &&
      std::uint64_t{job_.view().width()} * job_.view().height() > (std::uint64_t{1} << 30)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "integrator '", algorithm_->name, "' works on all pixels of the film at once; 2^30 are the most"));
  }
  if (algorithm_->joins_camera && camera.has_spherical()) {
    return absl::InvalidArgumentError(
        absl::StrCat("camera: integrator '", algorithm_->name, "' needs a perspective or orthographic one"));
  }
  switch (camera.kind_case()) {
    case v1::Camera::kPerspective: {
      const double fov = camera.perspective().fov_degrees();
      if (!(fov > 0 && fov < 180)) {
        return absl::InvalidArgumentError(
            absl::StrCat("camera: a field of view of ", fov, " degrees is not in (0, 180)"));
      }
      if (auto s = set_screen(std::tan(fov * 3.14159265358979323846 / 360)); !s.ok()) return s;
      return set_lens(camera.perspective().lens_radius(), camera.perspective().focal_distance());
    }
    case v1::Camera::kOrthographic:
      record.kind = CameraKind::kOrthographic;
      if (auto s = set_screen(1); !s.ok()) return s;
      return set_lens(camera.orthographic().lens_radius(), camera.orthographic().focal_distance());
    case v1::Camera::kSpherical:
      record.kind = camera.spherical().mapping() == v1::SphericalCamera::EQUAL_AREA_OCTAHEDRAL
                        ? CameraKind::kOctahedral
                        : CameraKind::kEquirectangular;
      record.scale_x = 1.0f / static_cast<float>(job_.view().width());
      record.scale_y = 1.0f / static_cast<float>(job_.view().height());
      return absl::OkStatus();
    case v1::Camera::KIND_NOT_SET:
      break;
  }
  return absl::InvalidArgumentError("camera: there is none, or its kind is unknown");
}

absl::Status SceneBuilder::set_camera_motion(const Transform& start) {
  const auto end = Transform::from_proto(scene_.camera().world_from_camera_end());
  if (!end.ok()) return end.status();
  const auto motion = Motion::between(start, *end);
  if (!motion.ok()) return motion.status();
  if (!motion->moves()) return absl::OkStatus();
  tables_.any_motion = true;
  return append_steps([&](double time) { return render_from_world_ * motion->at(time); }, motion->segments(),
                      tables_.camera.steps);
}

absl::Status SceneBuilder::set_screen(double half_side) {
  const v1::Camera& camera = scene_.camera();
  const double width = job_.view().width(), height = job_.view().height();
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
  CameraRecord& record = tables_.camera;
  record.scale_x = static_cast<float>((x_max - x_min) / width * half_side);
  record.scale_y = static_cast<float>((y_min - y_max) / height * half_side);
  record.offset_x = static_cast<float>(x_min * half_side);
  record.offset_y = static_cast<float>(y_max * half_side);
  if (!std::isfinite(record.scale_x + record.scale_y + record.offset_x + record.offset_y)) {
    return absl::InvalidArgumentError("camera: its screen window is not finite");
  }
  return absl::OkStatus();
}

absl::Status SceneBuilder::set_lens(float radius, float focal_distance) {
  tables_.camera.lens_radius = radius;
  tables_.camera.focal_distance = focal_distance;
  if (!(radius >= 0) || !std::isfinite(radius) ||
      (radius > 0 && !(focal_distance > 0 && std::isfinite(focal_distance)))) {
    return absl::InvalidArgumentError("camera: a lens needs a finite radius and a focal distance above 0");
  }
  return absl::OkStatus();
}

absl::Status SceneBuilder::build_filter() {
  const v1::PixelFilter& filter = scene_.film().filter();
  FilterSpec spec;
  float usual_radius = 0.5f;
  switch (filter.kind()) {
    case v1::PixelFilter::TRIANGLE:
      spec.kind = FilterKind::kTriangle, usual_radius = 2;
      break;
    case v1::PixelFilter::GAUSSIAN:
      spec.kind = FilterKind::kGaussian, usual_radius = 1.5f;
      break;
    case v1::PixelFilter::MITCHELL:
      spec.kind = FilterKind::kMitchell, usual_radius = 2;
      break;
    case v1::PixelFilter::LANCZOS:
      spec.kind = FilterKind::kLanczos, usual_radius = 4;
      break;
    default:
      break;
  }
  const auto positive_or = [](float x, float otherwise) { return x > 0 && std::isfinite(x) ? x : otherwise; };
  spec.radius_x = positive_or(filter.radius_x(), usual_radius);
  spec.radius_y = positive_or(filter.radius_y(), usual_radius);
  spec.sigma = positive_or(filter.sigma(), spec.sigma);
  spec.tau = positive_or(filter.tau(), spec.tau);
  if (filter.b() != 0 || filter.c() != 0) spec.b = filter.b(), spec.c = filter.c();
  if (!std::isfinite(spec.b) || !std::isfinite(spec.c) || std::max(spec.radius_x, spec.radius_y) > 1000) {
    return absl::InvalidArgumentError("film: the pixel filter's parameters are not usable");
  }
  tables_.filter = PixelFilterRecord::build(spec);
  return absl::OkStatus();
}

}  // namespace tessera::render
