// Points of a thin lens's aperture, evenly by area, or in proportion to what lets light through. The density
// over the lens is the same in rays as in connections, so that neither needs to know it; those that are
// joined evenly to all of a circle about the aperture have a density that is relative to that.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/sampling/piecewise2d_sample.h"
#include "render/sampling/warp.h"
#include "render/sensor/lens_table.h"
#include "render/sensor/sensor.h"

namespace tessera::render::TESSERA_ISA {

/// Moves points of the unit disk to the aperture and keeps ratios of areas: a sector of the disk becomes the
/// triangle of an edge and the middle, whose radii are scaled and whose angles are spread evenly over the
/// edge. Strata of the disk remain in one piece.
inline Vec2 disk_to_aperture(const ApertureRecord& aperture, Polar disk) {
  if (aperture.corners == 0)
    return {disk.radius * cos(disk.angle) * aperture.width, disk.radius * sin(disk.angle)};
  const float edge_angle = 2 * std::numbers::pi_v<float> / aperture.corners;
  const Float place = disk.angle * (1 / edge_angle), edge = floor(place);
  const Float middle = fma(edge + 0.5f, Float(edge_angle), Float(aperture.first_corner));
  const Float out = disk.radius * aperture.apothem;
  const Float along = disk.radius * fma(place - edge, Float(2.0f), Float(-1.0f)) * aperture.half_edge;
  const Float c = cos(middle), s = sin(middle);
  return {(out * c - along * s) * aperture.width, out * s + along * c};
}

/// A point of the aperture, in radii of the lens: of a picture, in proportion to what it lets through there.
inline Vec2 point_of_aperture(const LensTable& lens, Vec2 u_lens) {
  if (!lens.picture.any()) return disk_to_aperture(lens.aperture, square_to_disk_polar(u_lens));
  const Vec2 uv = locate_piecewise2d(lens.picture.density, u_lens, Mask::all()).uv;
  return {fma(uv.x, Float(2.0f), Float(-1.0f)) * lens.aperture.width, fma(uv.y, Float(2.0f), Float(-1.0f))};
}

inline Vec3 point_of_lens(const SensorRecord& sensor, Vec2 u_lens) {
  const Vec2 point = sensor.lens ? point_of_aperture(*sensor.lens, u_lens) : square_to_disk(u_lens);
  return {point.x * sensor.lens_radius, point.y * sensor.lens_radius, Float(0.0f)};
}

/// Radius of a circle about all of the aperture, in radii of the lens.
inline float radius_about(const LensTable& lens) {
  const float width = lens.aperture.width;
  return lens.picture.any() ? std::hypot(1.0f, width) : std::max(1.0f, width);
}

/// Density of points of the aperture relative to that of points that are spread evenly over the circle about
/// it: of a picture, where it is of mean brightness.
inline float mean_openness(const LensTable& lens) {
  const ApertureRecord& aperture = lens.aperture;
  const float circle = std::numbers::pi_v<float> * radius_about(lens) * radius_about(lens);
  if (lens.picture.any()) return circle / (4 * aperture.width);
  const float area = aperture.corners == 0 ? std::numbers::pi_v<float>
                                           : aperture.corners * aperture.apothem * aperture.half_edge;
  return circle / (area * aperture.width);
}

/// The same of a point of the circle, in radii of the lens; 0 where the aperture is shut.
inline Float openness_at(const LensTable& lens, Vec2 point) {
  const ApertureRecord& aperture = lens.aperture;
  const float mean = mean_openness(lens);
  const Float x = point.x * (1 / aperture.width), y = point.y;
  if (lens.picture.any()) {
    const Mask inside = (abs(x) <= 1.0f) & (abs(y) <= 1.0f);
    const Vec2 uv{fma(x, Float(0.5f), Float(0.5f)), fma(y, Float(0.5f), Float(0.5f))};
    return select_or_zero(inside, piecewise2d_density(lens.picture.density, uv, inside) * mean);
  }
  if (aperture.corners == 0) return select_or_zero(sqr(x) + sqr(y) <= 1.0f, Float(mean));
  const float edge_angle = 2 * std::numbers::pi_v<float> / aperture.corners;
  const Float place = (atan2(y, x) - aperture.first_corner) * (1 / edge_angle);
  const Float middle = fma(floor(place) + 0.5f, Float(edge_angle), Float(aperture.first_corner));
  return select_or_zero(x * cos(middle) + y * sin(middle) <= aperture.apothem, Float(mean));
}

/// The same of the point that a sample leads to.
inline Float openness_of_sample(const LensTable& lens, Vec2 u_lens) {
  const Float mean(mean_openness(lens));
  if (!lens.picture.any()) return mean;
  return sample_piecewise2d(lens.picture.density, u_lens, Mask::all()).density * mean;
}

/// Whether a ray from a point of the lens gets out of the barrel in front of it.
inline Mask leaves_barrel(const SensorRecord& sensor, Vec3 lens, Vec3 direction) {
  if (!sensor.has_barrel) return Mask::all();
  const float length = sensor.lens->barrel_length * sensor.lens_radius,
              radius = sensor.lens->barrel_radius * sensor.lens_radius;
  const Float t = length / direction.z;
  return sqr(fma(direction.x, t, lens.x)) + sqr(fma(direction.y, t, lens.y)) <= radius * radius;
}

}  // namespace tessera::render::TESSERA_ISA
