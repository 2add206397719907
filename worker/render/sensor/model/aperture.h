// Points of a thin lens's aperture, evenly by area, or in proportion to what lets light through. The density
// over the lens is the same in rays as in connections, so that neither needs to know it.
#pragma once

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

/// Whether a ray from a point of the lens gets out of the barrel in front of it.
inline Mask leaves_barrel(const SensorRecord& sensor, Vec3 lens, Vec3 direction) {
  if (!sensor.has_barrel) return Mask::all();
  const float length = sensor.lens->barrel_length * sensor.lens_radius,
              radius = sensor.lens->barrel_radius * sensor.lens_radius;
  const Float t = length / direction.z;
  return sqr(fma(direction.x, t, lens.x)) + sqr(fma(direction.y, t, lens.y)) <= radius * radius;
}

}  // namespace tessera::render::TESSERA_ISA
