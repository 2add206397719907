// Lenses by paraxial optics: rays so near to the axis that sines are angles.
#pragma once

#include <optional>

#include "optics/prescription.h"

namespace tessera::optics {

/// Distances along the axis are counted from the scene to the film, in millimetres: those at the front from
/// the first vertex, those at the back from the last one. A lens with cylinders is that across its y axis.
struct Paraxial {
  // From height and angle (slope, towards larger heights) of a ray before the first vertex to those behind
  // the last one, both in air: height' = a height + b angle, angle' = c height + d angle.
  double a = 1, b = 0, c = 0, d = 1;
  double length = 0;  // from the first vertex to the last one

  double focal_length() const { return -1 / c; }
  double front_focus() const { return d / c; }
  double back_focus() const { return -a / c; }
  double front_principal() const { return (d - 1) / c; }
  double back_principal() const { return (1 - a) / c; }
  bool has_power() const { return c != 0; }

  // Images of the stop, seen from the scene and from the film: places and magnifications.
  double entrance_pupil = 0, entrance_magnification = 1;
  double exit_pupil = 0, exit_magnification = 1;

  /// Where the film of things `object` before the first vertex lies, behind the last one.
  double image_of(double object) const { return -(a * object + b) / (c * object + d); }
  /// Size of the image over that of the thing, `object` before the first vertex; below 0: upside down.
  double magnification(double object) const { return 1 / (c * object + d); }
};

/// Sums a lens up at a wavelength; it must have a stop.
Paraxial paraxial_of(const Prescription& lens, double nm);

/// Seidel's sum of spherical aberration, in millimetres: rays that meet the first surface at `height`, of a
/// thing `object` before it (infinity: parallel to the axis), have a wavefront that is off by an eighth of it
/// at the edge [Welford 1986, Aberrations of Optical Systems, section 8.3].
double seidel_spherical(const Prescription& lens, double height, double object, double nm);

}  // namespace tessera::optics
