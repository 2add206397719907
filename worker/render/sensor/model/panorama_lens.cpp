// Longitude and latitude through a lens at right angles to each ray through its middle, as in Cycles: all
// rays of one place of the raster meet on a sphere about the sensor.
//
// The ray of the unit direction d through the point `l` of its lens, f being the focal distance, is
// l + t (f d - l). Its points at distances of `far` from the middle have
//
//     far^2 = (1 - t)^2 |l|^2 + t^2 f^2.
//
// No frame of the lenses turns along with d everywhere [Poincare 1885]: with a fixed point of the lens in the
// frames of longitudes, points near the poles lie on two rays or on none. Points are joined to rays evenly in
// the angle about the way to the middle instead, as rays through round lenses are, whatever their frames;
// where the lens is not round, its own shape decides.
#include "render/core/constants.h"
#include "render/sensor/model/aperture.h"
#include "render/sensor/model/flat_raster.h"
#include "render/sensor/model/panorama_place.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Unit vectors at right angles to a unit direction: level, to the right, and up.
struct LensAxes {
  Vec3 right, up;
};
LensAxes lens_axes(Vec3 direction) {
  const Float across = sqrt(sqr(direction.x) + sqr(direction.z));
  const Mask has_longitude = across > 1e-12f;
  const Float inverse = 1.0f / select(has_longitude, across, 1.0f);
  const Vec3 right{select(has_longitude, direction.z * inverse, 1.0f), Float(0.0f),
                   select_or_zero(has_longitude, direction.x * inverse) * -1.0f};
  return {right, cross(direction, right)};
}

/// How far a point of the lens is from its middle, and what follows from that.
struct Zone {
  Float squared;  // of the distance
  Float slant;    // length of f d - l
};
Zone zone_of(const SensorRecord& sensor, Float squared) {
  return {squared, sqrt(squared + sensor.focal_distance * sensor.focal_distance)};
}

/// How far a ray goes, from its point next to the middle to one that is `far` from there, times the slant.
/// Below 0: the ray comes nowhere near.
Float reach_times_slant(const SensorRecord& sensor, const Zone& zone, Float far) {
  const Float most = far * zone.slant, least = sensor.focal_distance * sqrt(zone.squared);
  return select(most >= least, safe_sqrt((most - least) * (most + least)), Float(-1.0f));
}

/// Density of rays at right angles to them, of those whose direction is `latitude_cosine` from the poles, if
/// they leave a round lens.
Float density_of_zone(const SensorRecord& sensor, const Zone& zone, Float far, Float reach,
                      Float latitude_cosine) {
  const Float places = max(latitude_cosine, 1e-6f) * pixel_area(sensor);
  return zone.slant / (max(far * reach, 1e-30f) * places);
}

class PanoramaLensSensor final : public SensorModel {
 public:
  PanoramaLensSensor()
      : SensorModel({.has_lens = true, .has_axis = false, .may_fail = true, .turns_lens = true}) {}

  LocalRay start(const SensorRecord& sensor, Vec2 place, Vec2 u_lens) const override {
    const Bearing bearing = bearing_of(place);
    const Float s = sin(bearing.longitude), c = cos(bearing.longitude);
    const Float up = sin(bearing.latitude), across = cos(bearing.latitude);
    const Vec3 flat = point_of_lens(sensor, u_lens);
    const Vec3 lens{fma(c, flat.x, up * s * flat.y * -1.0f), across * flat.y,
                    (s * flat.x + up * c * flat.y) * -1.0f};
    LocalRay ray;
    ray.direction = Vec3{across * s, up, across * c} * Float(sensor.focal_distance) - lens;
    ray.origin = nearest_to_middle(zone_of(sensor, sqr(flat.x) + sqr(flat.y)), lens, ray.direction);
    ray.valid = bearing.valid;
    return ray;
  }

  LocalConnection connect(const SensorRecord& sensor, Vec3 point, Vec2 u_lens) const override {
    const float most = sensor.lens ? radius_about(*sensor.lens) * sensor.lens_radius : sensor.lens_radius;
    const Polar disk = square_to_disk_polar(u_lens);
    const Float radius = disk.radius * most, far = length(point);
    const Zone zone = zone_of(sensor, sqr(radius));
    const Float reach = reach_times_slant(sensor, zone, far);
    // In the plane of the point, the middle and the lens's point, which lies in the direction `aside`.
    const Vec3 to_point = point * (1.0f / max(far, 1e-30f));
    const LensAxes axes = lens_axes(to_point);
    const Vec3 aside = fma(axes.right, cos(disk.angle), axes.up * sin(disk.angle));
    const Float t = (zone.squared + reach) / sqr(zone.slant), inverse = 1.0f / max(far, 1e-30f);
    const Float ahead = t * sensor.focal_distance * inverse, beside = (1.0f - t) * radius * inverse;
    const Vec3 direction = normalize(to_point * ahead - aside * beside),
               to_lens = normalize(fma(to_point, beside, aside * ahead));
    const Vec3 lens = to_lens * radius;

    const Float latitude_cosine = sqrt(sqr(direction.x) + sqr(direction.z));
    LocalConnection connection;
    connection.place = {longitude_in_picture(sensor, atan2(direction.x, direction.z)),
                        atan2(direction.y, latitude_cosine)};
    connection.lens =
        nearest_to_middle(zone, lens, fma(direction, Float(sensor.focal_distance), lens * -1.0f));
    connection.density = density_of_zone(sensor, zone, far, reach, latitude_cosine);
    connection.valid = reach > 0.0f;
    if (sensor.lens) {
      const LensAxes there = lens_axes(direction);
      const Float open = openness_at(*sensor.lens, {dot(lens, there.right) * (1 / sensor.lens_radius),
                                                    dot(lens, there.up) * (1 / sensor.lens_radius)});
      connection.density = connection.density * open;
      connection.valid &= open > 0.0f;
    }
    connection.importance = connection.density;
    return connection;
  }

  Float density_along(const SensorRecord& sensor, Vec3 point, Vec3 along, Vec2 u_lens) const override {
    const Vec3 flat = point_of_lens(sensor, u_lens);
    const Zone zone = zone_of(sensor, sqr(flat.x) + sqr(flat.y));
    const Float far = length(point), reach = max(reach_times_slant(sensor, zone, far), 0.0f);
    // The point next to the middle is (f^2 l + f |l|^2 d) / slant^2, and the ray goes along
    // (f d - l) / slant: solved for d.
    const Vec3 nearest = point - along * (reach / zone.slant);
    const Vec3 direction =
        fma(along, sensor.focal_distance / zone.slant, nearest * (1 / sensor.focal_distance));
    const Float density =
        density_of_zone(sensor, zone, far, reach, sqrt(sqr(direction.x) + sqr(direction.z)));
    return sensor.lens ? density * openness_of_sample(*sensor.lens, u_lens) : density;
  }

  Float pixel_width(const SensorRecord& sensor, Float distance) const override {
    return distance * pixel_step(sensor);
  }

 private:
  /// Rays begin where they are nearest to the middle, at t = |l|^2 / slant^2: none comes to a point twice.
  static Vec3 nearest_to_middle(const Zone& zone, Vec3 lens, Vec3 direction) {
    return fma(direction, zone.squared / sqr(zone.slant), lens);
  }
};

}  // namespace

const ModelOf<PanoramaLensSensor> panorama_lens(SensorKind::kPanoramaLens);

}  // namespace tessera::render::TESSERA_ISA
