// Points of a thin lens's aperture, evenly by area. The density over the lens is one over the aperture's area
// in rays as in connections, so that neither needs to know it.
#pragma once

#include <numbers>

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

inline Vec3 point_of_lens(const SensorRecord& sensor, Vec2 u_lens) {
  const Vec2 point = sensor.lens ? disk_to_aperture(sensor.lens->aperture, square_to_disk_polar(u_lens))
                                 : square_to_disk(u_lens);
  return {point.x * sensor.lens_radius, point.y * sensor.lens_radius, Float(0.0f)};
}

}  // namespace tessera::render::TESSERA_ISA
