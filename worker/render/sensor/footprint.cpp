#include "render/sensor/footprint.h"

#include "render/core/constants.h"
#include "render/sensor/distortion.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// A footprint on a surface that is seen from its edge has no end.
constexpr float kLeastCosine = 1.0f / 64, kLargest = 1e8f;

Vec3 broadcast(const float (&v)[3]) { return {Float(v[0]), Float(v[1]), Float(v[2])}; }

/// Finite, whatever comes in.
Float tame(Float x) { return clamp(select_or_zero(x == x, x), -kLargest, kLargest); }

/// Where an undistorted raster sees a unit direction, or for parallel rays a point, in coordinates of the
/// sensor's axes: places as the sensor's model has them.
Vec2 place_of(const FootprintRecord& sensor, Vec3 w) {
  const Float sine = sqrt(sqr(w.x) + sqr(w.y));
  const auto at_distance = [&](Float distance) {
    const Float part = select(sine > 1e-6f, distance / max(sine, 1e-6f), Float(1.0f));
    return Vec2{w.x * part, w.y * part};
  };
  switch (sensor.kind) {
    case SensorKind::kFisheyeEquidistant:
      return at_distance(atan2(sine, w.z));
    case SensorKind::kFisheyeEquisolid:
      return at_distance(safe_sqrt(2.0f - 2.0f * w.z));
    case SensorKind::kFisheyeStereographic:
      return at_distance(2.0f * sine / max(1.0f + w.z, 1e-6f));
    case SensorKind::kFisheyeOrthographic:
      return {w.x, w.y};
    default:
      break;
  }
  const Float depth = sensor.parallel ? Float(1.0f) : max(w.z, Float(sensor.least_cosine));
  return {w.x / (depth * sensor.units_x), w.y / (depth * sensor.units_y)};
}

}  // namespace

void set_footprint(const FootprintRecord& sensor, Vec3 n, Vec3 dpdu, Vec3 dpdv, TexturePoint& at) {
  const Vec3 x = broadcast(sensor.x), y = broadcast(sensor.y), z = broadcast(sensor.z);
  const Vec3 way = at.p - broadcast(sensor.place);
  // Two vectors at right angles to the ray: the sensor's axes turned with its own to the ray.
  Vec3 direction = z, across_x = x, across_y = y;
  Float size(1.0f);
  if (!sensor.parallel) {
    const Float distance = length(way);
    direction = way * (1.0f / max(distance, 1e-30f));
    const Float forward = dot(direction, z), sign = select(forward < 0.0f, Float(-1.0f), Float(1.0f));
    const Vec3 between = fma(z, sign, direction);
    const Float part = 1.0f / fma(forward, sign, Float(1.0f));
    across_x = x - between * (dot(direction, x) * part);
    across_y = y - between * (dot(direction, y) * part);
    // A pixel of a flat film takes up less of the sphere the farther it is from the axis, by the cube of the
    // cosine.
    const Float cosine = max(forward, Float(sensor.least_cosine));
    size = distance * cosine * sqrt(cosine);
  }
  // Along the ray to the surface's plane.
  const Float facing = dot(n, direction);
  const Float slope = 1.0f / copysign(max(abs(facing), Float(kLeastCosine)), facing);
  if (sensor.distortion != nullptr) {
    const Vec3 from = sensor.parallel ? way : direction;
    const PlaceSlopes by =
        slopes_near(*sensor.distortion, place_of(sensor, {dot(from, x), dot(from, y), dot(from, z)}));
    const float right_over_up = sensor.units_x / sensor.units_y;
    const Vec3 right = across_x, up = across_y;
    across_x = right * by.xx + up * (by.yx * (1.0f / right_over_up));
    across_y = up * by.yy + right * (by.xy * right_over_up);
  }
  const auto project = [&](Vec3 across, float spread) {
    const Vec3 step = across * (size * spread);
    return step - direction * (dot(n, step) * slope);
  };
  at.dpdx = project(across_x, sensor.spread_x);
  at.dpdy = project(across_y, sensor.spread_y);
  // Least squares: the step in u and v that comes closest to a step in space [pbrt-v4].
  const Float uu = length_squared(dpdu), uv = dot(dpdu, dpdv), vv = length_squared(dpdv);
  Float inverse = 1.0f / difference_of_products(uu, vv, uv, uv);
  inverse = select_or_zero(is_finite(inverse), inverse);
  const auto in_uv = [&](Vec3 step) {
    const Float u = dot(dpdu, step), v = dot(dpdv, step);
    return Vec2{tame(difference_of_products(vv, u, uv, v) * inverse),
                tame(difference_of_products(uu, v, uv, u) * inverse)};
  };
  at.duvdx = in_uv(at.dpdx);
  at.duvdy = in_uv(at.dpdy);
  at.has_footprint = true;
}

}  // namespace tessera::render::TESSERA_ISA
