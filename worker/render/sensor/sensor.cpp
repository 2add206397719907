#include "render/sensor/sensor.h"

#include <cassert>

#include "render/sensor/distortion.h"
#include "render/sensor/pose.h"

namespace tessera::render::TESSERA_ISA {

namespace {

constinit ModelTable<SensorModel, SensorKind> models;

Vec3 axis_of(const WideAffine& pose, int a) { return {pose.m[a], pose.m[4 + a], pose.m[8 + a]}; }

/// The model's densities are for areas of sensor space, as seen along the ray: volumes scale by the product
/// of the axes' lengths, and the ray takes its own part of that.
Float scale_of_density(const WideAffine& pose, Vec3 along_ray) {
  const Float volume = length(axis_of(pose, 0)) * length(axis_of(pose, 1)) * length(axis_of(pose, 2));
  return length(transform_vector(pose, along_ray)) / (length(along_ray) * volume);
}

/// Length of a ray of unit direction for every unit of depth.
Float length_per_depth(const SensorRecord& sensor, const WideAffine& pose, Vec3 direction) {
  if (!sensor_model(sensor.kind).traits.has_axis) return Float(1.0f);
  const Vec3 forward = normalize(Vec3{pose.m[2], pose.m[6], pose.m[10]});
  return 1.0f / max(dot(direction, forward), 1e-6f);
}

/// A vector of render space in sensor space, whose axes are orthogonal, but may be scaled.
Vec3 in_sensor(const WideAffine& pose, Vec3 v) {
  const auto along = [&](int a) {
    const Vec3 axis = axis_of(pose, a);
    return dot(v, axis) / length_squared(axis);
  };
  return {along(0), along(1), along(2)};
}

}  // namespace

LocalConnection SensorModel::connect(const SensorRecord&, Vec3, Vec2) const {
  assert(!"a model that connects to points says how");
  return {};
}

LocalConnection SensorModel::connect_dispersed(const SensorRecord& sensor, Vec3 point, Vec2 u_lens,
                                               Float) const {
  return connect(sensor, point, u_lens);
}

Float SensorModel::density_along(const SensorRecord&, Vec3, Vec3, Vec2) const {
  assert(!"a model that turns its lens says how");
  return Float(0.0f);
}

LocalRay SensorModel::start_dispersed(const SensorRecord& sensor, Vec2 place, Vec2 u_lens, Float) const {
  return start(sensor, place, u_lens);
}

const SensorModel& sensor_model(SensorKind kind) { return *models[kind]; }

void set_model(SensorKind kind, const SensorModel& model) { models.set(kind, model); }

SensorKind add_sensor_model(const SensorModel& model) { return models.add(model); }

SensorRay start_ray(const SensorRecord& sensor, const SensorSample& sample) {
  Vec2 place{fma(sample.raster.x, Float(sensor.scale_x), Float(sensor.offset_x)),
             fma(sample.raster.y, Float(sensor.scale_y), Float(sensor.offset_y))};
  Mask on_film = Mask::all();
  if (sensor.distortion) {
    const MovedPlace seen = undistort(*sensor.distortion, place);
    place = seen.place, on_film = seen.valid;
  }
  const SensorModel& model = sensor_model(sensor.kind);
  LocalRay ray = sensor.disperses ? model.start_dispersed(sensor, place, sample.u_lens, sample.wavelength)
                                  : model.start(sensor, place, sample.u_lens);
  if (sensor.distortion) ray.valid &= on_film;
  const WideAffine pose = pose_at(sensor, sample.time);
  SensorRay result{transform_vector(pose, ray.origin),
                   normalize(transform_vector(pose, ray.direction)),
                   select_or_zero(ray.valid, ray.weight),
                   ray.valid,
                   ray.pdf,
                   ray.tint,
                   ray.normal};
  if (is_elsewhere(sensor)) result.origin = result.origin + place_of(pose);
  if (sensor.near_clip > 0) {
    const Float per_depth = length_per_depth(sensor, pose, result.direction);
    result.origin = fma(result.direction, sensor.near_clip * per_depth, result.origin);
  }
  return result;
}

SensorConnection connect_to_sensor(const SensorRecord& sensor, Vec3 point, Vec2 u_lens, Float time,
                                   Mask active, Float wavelength) {
  const WideAffine pose = pose_at(sensor, time);
  if (is_elsewhere(sensor)) point = point - place_of(pose);
  const Vec3 p = in_sensor(pose, point);
  const Float unit_of_depth = length(axis_of(pose, 2));
  const bool has_axis = sensor_model(sensor.kind).traits.has_axis;
  const Mask in_front = active & ((has_axis ? p.z : length(point)) > 0.0f);
  const Vec3 seen{p.x, p.y, select(in_front, p.z, 1.0f)};
  const SensorModel& model = sensor_model(sensor.kind);
  LocalConnection local = sensor.disperses ? model.connect_dispersed(sensor, seen, u_lens, wavelength)
                                           : model.connect(sensor, seen, u_lens);
  if (sensor.distortion) {
    const MovedPlace film = distort(*sensor.distortion, local.place);
    local.place = film.place;
    // The samples of a pixel are spread over the undistorted places that it sees.
    const Float density = 1.0f / max(film.area, 1e-20f);
    local.importance = local.importance * density, local.density = local.density * density;
    local.valid &= film.valid;
  }
  SensorConnection result;
  result.raster = {(local.place.x - sensor.offset_x) * (1 / sensor.scale_x),
                   (local.place.y - sensor.offset_y) * (1 / sensor.scale_y)};
  result.lens = transform_vector(pose, local.lens);
  const Float depth = has_axis ? (p.z - local.lens.z) * unit_of_depth : length(point - result.lens);
  if (is_elsewhere(sensor)) result.lens = result.lens + place_of(pose);
  const Float scale = scale_of_density(pose, p - local.lens);
  result.importance = local.importance * scale;
  result.density = local.density * scale;
  result.open_part = sensor.near_clip > 0 ? 1.0f - sensor.near_clip / max(depth, 1e-30f) : Float(1.0f);
  result.valid = in_front & local.valid & (depth > sensor.near_clip);
  if (sensor.far_clip > 0) result.valid &= depth <= sensor.far_clip;
  return result;
}

Float density_of_rays(const SensorRecord& sensor, Vec3 point, Vec3 direction, Vec2 u_lens, Float time,
                      Mask active, Float wavelength) {
  const SensorModel& model = sensor_model(sensor.kind);
  if (!model.traits.turns_lens)
    return connect_to_sensor(sensor, point, u_lens, time, active, wavelength).density;
  const WideAffine pose = pose_at(sensor, time);
  if (is_elsewhere(sensor)) point = point - place_of(pose);
  const Vec3 along = normalize(in_sensor(pose, direction));
  return model.density_along(sensor, in_sensor(pose, point), along, u_lens) * scale_of_density(pose, along);
}

Vec3 normal_in_sensor(const SensorRecord& sensor, Vec3 normal, Float time) {
  const Vec3 n = transform_normal(pose_at(sensor, time), normal);
  return n * (1.0f / sqrt(max(length_squared(n), 1e-30f)));
}

Mask is_within_reach(const SensorRecord& sensor, Vec3 direction, Float t, Float time) {
  if (!(sensor.far_clip > 0)) return Mask::all();
  const Float per_depth = length_per_depth(sensor, pose_at(sensor, time), direction);
  return t <= (sensor.far_clip - sensor.near_clip) * per_depth;
}

}  // namespace tessera::render::TESSERA_ISA
