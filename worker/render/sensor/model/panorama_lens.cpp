// A panorama with a lens at right angles to each direction, as Cycles has it: what lies on a sphere about the
// sensor is sharp. The lens's x axis is that of the longitude's frame.
#include "render/sensor/model/aperture.h"
#include "render/sensor/model/flat_raster.h"
#include "render/sensor/model/panorama_raster.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Points of the ray through the point (a, b) of the lens are, with s from 0 at the lens to 1 where it is
/// sharp,
///   lens (1 - s) + d focus s,  lens = (a, b cos, -b sin),  d = (0, sin, cos) of the latitude,
/// in the frame of the longitude.
class PanoramaLensSensor final : public SensorModel {
 public:
  PanoramaLensSensor() : SensorModel({.has_lens = true, .has_axis = false, .may_fail = true}) {}

  LocalRay start(const SensorRecord& sensor, Vec2 place, Vec2 u_lens) const override {
    const PanoramaPlace at = panorama_place(place);
    const Float s = sin(at.latitude), c = cos(at.latitude), focus(sensor.focal_distance);
    const Vec3 lens = point_of_lens(sensor, u_lens);
    const Vec3 origin = on_lens(lens, s, c);
    LocalRay ray{from_longitude(at.longitude, origin),
                 from_longitude(at.longitude, Vec3{Float(0.0f), focus * s, focus * c} - origin)};
    ray.valid = at.valid & leaves_barrel(sensor, lens, towards_focus(sensor, lens));
    return ray;
  }

  LocalConnection connect(const SensorRecord& sensor, Vec3 point, Vec2 u_lens) const override {
    const Vec3 lens = point_of_lens(sensor, u_lens);
    const Float focus(sensor.focal_distance);
    // How far along, by the distance from the middle: that of the lens and that of what is sharp add up in
    // squares.
    const Float radius = sqr(lens.x) + sqr(lens.y), reach = radius + sqr(focus), away = length_squared(point);
    const Float s = (radius + safe_sqrt(sqr(radius) + reach * (away - radius))) / reach, rest = 1.0f - s;
    // The height is A sin(latitude + tilt), and what is ahead A cos(latitude + tilt).
    const Float beside = lens.x * rest, raised = lens.y * rest;
    const Float squared = max(sqr(raised) + sqr(focus * s), 1e-30f), tilt = atan2(raised, focus * s);
    const Float sine = clamp(point.y / sqrt(squared), -1.0f, 1.0f);
    const Float angle = asin(sine), lower = angle - tilt,
                upper = copysign(Float(kPi), point.y) - angle - tilt;
    // About the pole that the point of the lens is turned to, two directions lead to the point; about the
    // other one, none does. Of two, one is taken by chance: by digits of the number that chose the point,
    // which do not move it.
    const Mask both = (abs(lower) <= kQuarterTurn) & (abs(upper) <= kQuarterTurn);
    const Float digits = u_lens.y * 4194304.0f;
    const Mask second = both & (floor(digits * 0.5f) * 2.0f < floor(digits));
    const Float latitude = select(second, upper, lower);
    const Float ahead_squared = squared - sqr(point.y);
    const Float ahead = safe_sqrt(ahead_squared) * select(second, Float(-1.0f), Float(1.0f));
    const Float longitude = longitude_in_picture(sensor, atan2(point.x, point.z) - atan2(beside, ahead));

    const Float sl = sin(latitude), cl = cos(latitude);
    const Vec3 origin = on_lens(lens, sl, cl);
    const Vec3 along = Vec3{Float(0.0f), focus * sl, focus * cl} - origin;
    const Float density = panorama_density(sensor, {ahead, Float(0.0f), beside * -1.0f},
                                           {Float(0.0f), ahead, point.y * -1.0f}, along) *
                          select(both, Float(2.0f), Float(1.0f));
    LocalConnection connection{{longitude, latitude}, from_longitude(longitude, origin), density, density};
    connection.valid = (away > radius) & (ahead_squared > 1e-6f * squared) & (abs(latitude) <= kQuarterTurn) &
                       leaves_barrel(sensor, lens, towards_focus(sensor, lens));
    return connection;
  }

  Float pixel_width(const SensorRecord& sensor, Float distance) const override {
    return distance * pixel_step(sensor);
  }

 private:
  static Vec3 on_lens(Vec3 lens, Float sine, Float cosine) {
    return {lens.x, lens.y * cosine, lens.y * sine * -1.0f};
  }
  /// From a point of the lens, in the lens's own space.
  static Vec3 towards_focus(const SensorRecord& sensor, Vec3 lens) {
    return {lens.x * -1.0f, lens.y * -1.0f, Float(sensor.focal_distance)};
  }
};

}  // namespace

const ModelOf<PanoramaLensSensor> panorama_lens(SensorKind::kPanoramaLens);

}  // namespace tessera::render::TESSERA_ISA
